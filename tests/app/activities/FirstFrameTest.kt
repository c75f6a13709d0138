package org.fluxgs.app

import android.content.Intent
import android.net.Uri
import java.io.File
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode

/**
 * Start of the app until the sample is on the screen, in a Java machine that has loaded nothing yet. Other
 * scenes by hand: -Dfluxgs.scene=FILE, of which -Dfluxgs.memory=MIB of the device are free.
 */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class FirstFrameTest {
    @Test
    fun comesSoon() {
        pauseDisplay()
        val context = RuntimeEnvironment.getApplication()
        System.getProperty("fluxgs.memory")?.let { memory(it.toLong() shl 20) }
        val scene = System.getProperty("fluxgs.scene")?.let { Uri.fromFile(File(it)) } ?: Scene.SAMPLE
        System.gc()
        runCatching { File("/proc/self/clear_refs").writeText("5") } // the peak begins anew, where that is allowed
        val before = memoryOf("VmRSS")
        val begin = System.nanoTime()
        val intent = Intent(context, ViewerActivity::class.java).setData(scene)
        val controller = Robolectric.buildActivity(ViewerActivity::class.java, intent).setup()
        val surface = controller.get().view(R.id.surface) as SceneSurface
        giveSurface(surface, 640, 480)
        until("the scene is drawn") { surface.session!!.state()!!.drawn }
        val all = (System.nanoTime() - begin) / 1e6
        val load = surface.session!!.state()!!.firstFrameMs
        val more = memoryOf("VmHWM") - before
        val stats = surface.session!!.state()!!.stats
        val text = "%.0f ms from before the activity's onCreate, %.0f of them since its file was open; " +
            "%d MiB more at most; %d of %d splats, degree %d of %d\n"
        File(screens, "first-frame.txt").apply { parentFile!!.mkdirs() }.writeText(
            text.format(all, load, more, stats.shown, stats.splats, stats.shDegree, stats.fileShDegree),
        )
        controller.end()
        val patience = if (scene == Scene.SAMPLE) 20_000 else 300_000
        assertTrue("$all ms", load in 1.0..all && all < patience)
    }

    /** MiB of this process. */
    private fun memoryOf(name: String): Long =
        File("/proc/self/status").readLines().first { it.startsWith("$name:") }.filter { it.isDigit() }.toLong() shr 10
}
