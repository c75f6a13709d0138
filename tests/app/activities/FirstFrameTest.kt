package org.fluxgs.app

import android.content.Intent
import java.io.File
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode

/** Start of the app until the sample is on the screen, in a Java machine that has loaded nothing yet. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class FirstFrameTest {
    @Test
    fun comesSoon() {
        pauseDisplay()
        val context = RuntimeEnvironment.getApplication()
        val begin = System.nanoTime()
        val intent = Intent(context, ViewerActivity::class.java).setData(Scene.SAMPLE)
        val controller = Robolectric.buildActivity(ViewerActivity::class.java, intent).setup()
        val surface = controller.get().view(R.id.surface) as SceneSurface
        giveSurface(surface, 640, 480)
        until("the scene is drawn") { surface.session!!.state()!!.drawn }
        val all = (System.nanoTime() - begin) / 1e6
        val load = surface.session!!.state()!!.firstFrameMs
        val text = "%.0f ms from before the activity's onCreate, %.0f of them since its file was open\n"
        File(screens, "first-frame.txt").apply { parentFile!!.mkdirs() }.writeText(text.format(all, load))
        controller.end()
        assertTrue("$all ms", load in 1.0..all && all < 20_000)
    }
}
