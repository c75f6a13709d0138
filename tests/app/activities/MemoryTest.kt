package org.fluxgs.app

import android.content.ComponentCallbacks2
import android.content.Intent
import android.view.ContextThemeWrapper
import android.view.LayoutInflater
import android.view.View
import android.widget.TextView
import java.io.File
import java.io.RandomAccessFile
import java.nio.ByteBuffer
import java.nio.ByteOrder
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNull
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowToast

/** A viewer whose phone has little memory, for a while or for ever. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class MemoryTest : ViewerScreen() {
    /** A .splat of small grey ones, side by side. */
    private fun splats(count: Int): ByteArray {
        val bytes = ByteBuffer.allocate(32 * count).order(ByteOrder.LITTLE_ENDIAN)
        for (i in 0 until count) {
            bytes.putFloat(0.01f * (i % 1000)).putFloat(0.01f * (i / 1000)).putFloat(0f)
            repeat(3) { bytes.putFloat(0.005f) }
            repeat(5) { bytes.put(255.toByte()) } // colour, opacity, and w of no turn
            repeat(3) { bytes.put(128.toByte()) }
        }
        return bytes.array()
    }

    /** The scene with a chunk behind it that means nothing. */
    private fun writePadded(file: File, size: Int) {
        val scene = File(material, "scene.glb").readBytes()
        val patched = ByteBuffer.wrap(scene).order(ByteOrder.LITTLE_ENDIAN).putInt(8, size)
        RandomAccessFile(file, "rw").use {
            it.write(patched.array())
            val header = ByteBuffer.allocate(8).order(ByteOrder.LITTLE_ENDIAN)
            it.write(header.putInt(size - scene.size - 8).putInt(0x454E4F4E).array())
            it.setLength(size.toLong())
        }
    }

    /** Its file is read in parts, and needs no room. */
    @Test
    fun aSceneThatIsTooLargeIsShownInPart() {
        memory(100L shl 20) // of which a scene always may take 64 MB
        val file = File(context.cacheDir, "huge.splat").apply { writeBytes(splats(1_400_000)) }
        openAndDraw(Documents.offer(file))
        val stats = session.state()!!.stats
        assertEquals(1_400_000L, stats.splats)
        assertTrue("$stats", stats.shown in 200_000..1_100_000)
        val said = "${Texts.millions(stats.shown)} of 1.4 M splats"
        until("the app says how much is shown") { said in activity.text(R.id.hud) }
    }

    @Test
    fun aSceneThatHasNoRoomBesideTheFirstIsOpenedWhenTriedAgain() {
        openAndDraw()
        val first = session
        memory(270L shl 20) // of which a scene may take 60 MB, and 64 it always may
        val file = File(context.cacheDir, "large.glb").apply { writePadded(this, 100 shl 20) }
        controller!!.newIntent(
            Intent(context, ViewerActivity::class.java).setData(Documents.offer(file)),
        )
        until("the app says that it cannot") { activity.isShown(R.id.loading_retry) }
        assertEquals(context.getString(R.string.scene_no_memory), activity.text(R.id.loading_detail))
        assertTrue(activity.text(R.id.loading_cause), "may be used" in activity.text(R.id.loading_cause))
        assertTrue("the first is still there", session.state()!!.hasScene)
        memory(500L shl 20) // without it
        press(R.id.loading_retry)
        assertNull("the first has made room", first.state())
        until("the second is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
    }

    /** As large as a phone's screen, whose image takes more than the scene. */
    private fun openOnAPhone(): Stats {
        memory(2L shl 30)
        openAndDraw()
        giveSurface(activity.view(R.id.surface) as SceneSurface, 1080, 2340)
        until("the image has its size") { session.state()!!.stats.width == 1080 }
        return session.state()!!.stats
    }

    private fun expectLess(before: Stats) {
        until("there is less") { session.state()!!.stats.reduced }
        val less = session.state()!!.stats
        assertTrue("$less", less.memory <= before.memory * 3 / 4)
        assertEquals("pixels go last", 1080, less.width)
        assertEquals("splats are little here", before.splats, less.shown)
        assertTrue("there is an image", spread(settled()) > 100)
        assertEquals(context.getString(R.string.memory_short), ShadowToast.getTextOfLatestToast())
        until("the numbers say so") { context.getString(R.string.reduced_memory) in activity.text(R.id.hud) }
    }

    private fun expectAllAgain(before: Stats) {
        until("all of it is there again") { pump(5_000); session.state()!!.stats.memory == before.memory }
        assertFalse("nothing is left out", session.state()!!.stats.reduced)
    }

    @Test
    fun whenTheSystemWantsMemoryTheImageGetsLessUntilThereIsRoom() {
        val before = openOnAPhone()
        assertFalse(before.reduced)
        @Suppress("DEPRECATION")
        controller!!.get().onTrimMemory(ComponentCallbacks2.TRIM_MEMORY_RUNNING_CRITICAL)
        expectLess(before)
        memory(100L shl 20)
        pump(GraphicsBudget.FIRST_PATIENCE_MS + GraphicsBudget.ASK_EVERY_MS)
        assertTrue("there is no room yet", session.state()!!.stats.reduced)
        memory(2L shl 30)
        expectAllAgain(before)
    }

    /** Android 14 and later tell nobody. */
    @Test
    fun memoryThatBecomesShortIsNoticed() {
        val before = openOnAPhone()
        pump(GraphicsBudget.ASK_EVERY_MS)
        assertFalse("there is no want", session.state()!!.stats.reduced)
        memory(50L shl 20, low = true)
        pump(GraphicsBudget.ASK_EVERY_MS)
        expectLess(before)
        val less = session.state()!!.stats.memory
        pump(GraphicsBudget.EFFECT_MS / 2)
        assertEquals("it waits for the effect", less, session.state()!!.stats.memory)
        pump(GraphicsBudget.EFFECT_MS)
        until("there is less again") { session.state()!!.stats.memory < less }
        memory(2L shl 30)
        expectAllAgain(before)
    }

    /** Another app may open a scene by this one while this one's own is behind it. */
    @Test
    fun aViewerThatNobodySeesMakesRoomForAnother() {
        openAndDraw()
        drag(320f to 240f, 380f to 240f)
        val (below, before) = Pair(controller!!, settled())
        below.pause().stop()
        val first = session
        val text = File(context.cacheDir, "text.glb").apply { writeText("no scene") }
        openAndFail(Documents.offer(text)) // for want of memory, say
        press(R.id.loading_retry)
        assertNull("its memory is free", first.state())
        controller!!.end()
        controller = below
        below.restart().start().resume()
        giveSurface(activity.view(R.id.surface) as SceneSurface, WIDTH, HEIGHT)
        until("the scene is there again") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        assertTrue("where it was looked at", psnr(before, settled()) > 45)
    }

    /** Or the system would end the app, as one that has much. */
    @Test
    fun whenTheSystemWantsMemoryOfAnAppThatNobodySeesItsSceneIsReadAgainLater() {
        openAndDraw()
        drag(320f to 240f, 380f to 240f)
        val (first, before) = Pair(session, settled())
        controller!!.pause().stop()
        @Suppress("DEPRECATION")
        controller!!.get().onTrimMemory(ComponentCallbacks2.TRIM_MEMORY_BACKGROUND)
        assertNull("its memory is free", first.state())
        controller!!.restart().start().resume()
        giveSurface(activity.view(R.id.surface) as SceneSurface, WIDTH, HEIGHT)
        until("the scene is there again") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        assertTrue("where it was looked at", psnr(before, settled()) > 45)
    }

    @Test
    fun inTheBackgroundGraphicsMemoryIsGivenBackAndTheSceneComesAgain() {
        openAndDraw()
        val before = settled()
        val splats = session.state()!!.stats.shown
        controller!!.pause().stop()
        until("it is given back") { session.state()!!.stats.memory == 0L }
        assertNull("there is nothing to see", session.image())
        controller!!.restart().start().resume()
        until("it is drawn with again") { session.state()!!.stats.memory > 0 }
        assertTrue(psnr(before, settled()) > 45)
        assertEquals("all of it", splats, session.state()!!.stats.shown)
    }

    @Test
    fun theBudgetOfGraphicsShrinksAndWaitsLongerEachTime() {
        memory(2L shl 30)
        val budget = GraphicsBudget(context)
        val whole = budget.bytes
        val taken = 200L shl 20
        assertFalse("there is no scene", budget.shrink(0))
        assertTrue(budget.shrink(taken))
        assertEquals(150L shl 20, budget.bytes)
        assertFalse("its effect is not known yet", budget.shrink(150L shl 20))
        for (patience in listOf(1, 2, 4)) {
            pump(patience * GraphicsBudget.FIRST_PATIENCE_MS - 1000)
            assertFalse(budget.look(150L shl 20, true))
            pump(GraphicsBudget.ASK_EVERY_MS)
            assertFalse("nothing is left out", budget.look(150L shl 20, false))
            pump(GraphicsBudget.ASK_EVERY_MS)
            assertTrue(budget.look(150L shl 20, true))
            assertEquals(whole, budget.bytes)
            assertTrue(budget.shrink(taken))
        }
        repeat(20) {
            pump(GraphicsBudget.EFFECT_MS)
            budget.shrink(budget.bytes)
        }
        assertEquals(GraphicsBudget.LEAST, budget.bytes)
    }

    @Test
    fun aSceneThatWasOpenedInLittleMemoryGetsMoreOnceThereIs() {
        memory(200L shl 20)
        val budget = GraphicsBudget(context)
        val little = budget.bytes
        memory(260L shl 20)
        assertFalse("hardly more", budget.look(little, true))
        memory(2L shl 30)
        pump(GraphicsBudget.ASK_EVERY_MS)
        assertTrue(budget.look(little, true))
        assertTrue(budget.bytes > 4 * little)
    }

    @Test
    fun aSceneThatIsDrawnAnewSaysSo() {
        fun drawn(memory: Long) = SessionState(
            Loading("ready", 0, 0, "", "", "", 0, 0), true, true, false, 1, false, "", "", 1, 0, 0.0,
            Stats(0.0, 60.0, 0.0, 0.0, 0, 0, 0, 0, 0, 0, 0, 1.0, memory, false, 1.0, 1.0),
        )
        val themed = ContextThemeWrapper(RuntimeEnvironment.getApplication(), R.style.App_Viewer)
        val root = LayoutInflater.from(themed).inflate(R.layout.viewer, null).findViewById<View>(R.id.loading)
        val view = LoadingView(root, LoadingView.Actions({}, {}, {}, {}))
        view.show(drawn(0), "fox.glb") { 0 }
        assertEquals("not for the moment that a small one takes", View.GONE, root.visibility)
        view.show(drawn(0), "fox.glb") { 0 }
        assertEquals(View.VISIBLE, root.visibility)
        assertTrue("fox" in root.findViewById<TextView>(R.id.loading_title).text)
        assertEquals(View.GONE, root.findViewById<View>(R.id.loading_cancel).visibility)
        view.show(drawn(1), "fox.glb") { 0 }
        assertEquals(View.GONE, root.visibility)
    }

    @Test
    fun memoryIsSpokenOfWhereThereIsLittle() {
        val loading = Loading("reading", 3_000_000, 7_000_000, "", "", "ply", 1000, 30_000_000)
        val state = SessionState(
            loading, false, false, false, 0, false, "", "", 1, 0, 0.0,
            Stats(0.0, 60.0, 0.0, 0.0, 0, 0, 0, 0, 0, 0, 0, 1.0, 0, false, 1.0, 1.0),
        )
        val themed = ContextThemeWrapper(RuntimeEnvironment.getApplication(), R.style.App_Viewer)
        val root = LayoutInflater.from(themed).inflate(R.layout.viewer, null).findViewById<View>(R.id.loading)
        val view = LoadingView(root, LoadingView.Actions({}, {}, {}, {}))
        val detail = root.findViewById<TextView>(R.id.loading_detail)
        view.show(state, "fox.glb") { 1_000_000_000 }
        assertEquals("3.0 MB of 7.0 MB", detail.text.toString())
        view.show(state, "fox.glb") { 50_000_000 }
        assertEquals("Needs about 60 MB of memory; 100 MB are free.", detail.text.lines().last())
    }
}
