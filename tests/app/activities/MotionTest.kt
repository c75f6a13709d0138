package org.fluxgs.app

import android.app.Activity
import android.content.Intent
import android.graphics.Bitmap
import android.net.Uri
import android.os.SystemClock
import android.view.InputDevice
import android.view.KeyEvent
import android.view.Menu
import android.view.MenuItem
import android.view.MotionEvent
import java.io.File
import kotlin.math.abs
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNull
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowPopupMenu
import org.robolectric.shadows.ShadowToast

/** What moves the view by itself. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class MotionTest : ViewerScreen() {
    private fun menu(): Menu {
        press(R.id.motion)
        return ShadowPopupMenu.getLatestPopupMenu().menu
    }

    private fun entry(label: Int): MenuItem? = menu().findItem(label)

    private fun choose(label: Int) {
        assertTrue(menu().performIdentifierAction(label, 0))
        pump()
    }

    private fun chooseView(group: Int, number: Int) {
        assertTrue(entry(group)!!.subMenu!!.performIdentifierAction(number, 0))
        pump()
    }

    private fun turns() {
        val before = session.place()!!
        until("it turns") { !before.contentEquals(session.place()!!) }
    }

    private fun moves(how: String) = until("it is '$how'") { session.state()!!.motion == how }

    /** What a system is told of a drawing thread. */
    private class ToldHints(val thread: Int, var target: Long) : HintSession {
        val reports = mutableListOf<Long>()
        var closed = false
        override fun report(nanoseconds: Long) { reports += nanoseconds }
        override fun target(nanoseconds: Long) { target = nanoseconds }
        override fun close() { closed = true }
    }

    @Test
    fun theSystemIsToldHowLongFramesTakeWhileSomethingMoves() {
        val told = mutableListOf<ToldHints>()
        val before = PerformanceHints.opener
        try {
            PerformanceHints.opener = { _, thread, target -> ToldHints(thread, target).also { told += it } }
            openAndDraw()
            choose(R.string.auto_orbit)
            moves("drift")
            until("frames are reported") { told.isNotEmpty() && told.last().reports.size > 3 }
            val hints = told.last()
            assertEquals(session.drawingThread(), hints.thread)
            assertTrue("a thread of this process", File("/proc/self/task/${hints.thread}").exists())
            assertTrue("${hints.target}", hints.target in 1_000_000..100_000_000)
            assertTrue("${hints.reports}", hints.reports.all { it in 1..10_000_000_000 })
            choose(R.string.auto_orbit)
            moves("")
            until("nothing is told at rest") { told.all { it.closed } }
        } finally {
            PerformanceHints.opener = before
        }
    }

    // Auto-orbit

    @Test
    fun aSceneTurnsFromTheStartUntilItIsTouched() {
        animations(1f)
        openAndDraw()
        moves("drift")
        turns()
        touch(MotionEvent.ACTION_DOWN, 0, 320f to 240f)
        touch(MotionEvent.ACTION_UP, 400, 320f to 240f)
        moves("")
        settled()
    }

    @Test
    fun theMenuStartsAndStopsIt() {
        openAndDraw()
        assertFalse(entry(R.string.auto_orbit)!!.isChecked)
        choose(R.string.auto_orbit)
        moves("drift")
        assertTrue(entry(R.string.auto_orbit)!!.isChecked)
        choose(R.string.auto_orbit)
        moves("")
        settled()
    }

    @Test
    fun nothingMovesWhereTheSystemReducesMotion() {
        openAndDraw()
        pump(500)
        assertEquals("", session.state()!!.motion)
        session.drift(true)
        moves("drift")
        controller!!.pause().resume()
        moves("")
    }

    @Test
    fun nothingMovesWhereTheSettingIsOff() {
        animations(1f)
        openAndDraw()
        choose(R.string.auto_orbit_at_start)
        assertFalse(Settings.load(context).autoOrbit)
        close()
        openAndDraw()
        pump(500)
        assertEquals("", session.state()!!.motion)
    }

    @Test
    fun theScreenDoesNotStayOnForIt() {
        animations(1f)
        openAndDraw()
        moves("drift")
        pump(ViewerActivity.AWAKE_MS)
        pump(300)
        assertFalse(activity.view(R.id.surface).keepScreenOn)
        assertEquals("drift", session.state()!!.motion)
    }

    // Saved views and paths

    private fun isNear(place: DoubleArray) = session.place()!!.indices.all { abs(session.place()!![it] - place[it]) < 1e-6 }

    @Test
    fun viewsAreSavedGoneToPlayedAndDeleted() {
        openAndDraw()
        assertNull(entry(R.string.saved_views))
        choose(R.string.save_view)
        val first = session.place()!!
        drag(320f to 240f, 420f to 250f)
        settled()
        val second = session.place()!!
        assertNull("one view is no path", entry(R.string.play_views))
        choose(R.string.save_view)
        chooseView(R.string.saved_views, 1)
        until("it is the first view") { isNear(first) }
        choose(R.string.play_views)
        moves("path")
        turns()
        choose(R.string.stop_path)
        moves("")
        close()
        openAndDraw()
        chooseView(R.string.saved_views, 2)
        until("it is the second view") { isNear(second) }
        chooseView(R.string.delete_view, 1)
        assertEquals(1, SavedViews(context, Scene.SAMPLE).all().size)
        assertEquals(second[0], SavedViews(context, Scene.SAMPLE).all()[0][0], 1e-12)
        Recents(context).forget(Scene.SAMPLE)
        assertEquals(0, SavedViews(context, Scene.SAMPLE).all().size)
    }

    @Test
    fun thereIsAnEndToSavedViews() {
        val views = SavedViews(context, Scene.SAMPLE)
        repeat(SavedViews.MOST) { assertTrue(views.add(DoubleArray(12))) }
        assertFalse(views.add(DoubleArray(12)))
    }

    private fun openPath(text: String) {
        val file = File(context.filesDir, "path.json")
        file.writeText(text)
        choose(R.string.open_path)
        val asked = shadowOf(activity).nextStartedActivityForResult
        assertEquals(Intent.ACTION_OPEN_DOCUMENT, asked.intent.action)
        shadowOf(activity).receiveResult(asked.intent, Activity.RESULT_OK, Intent().setData(Uri.fromFile(file)))
    }

    private fun track(times: String = "0, 30") = """{"version": 2, "animTracks": [{"duration": 2, "frameRate": 30,
        "loopMode": "repeat", "smoothness": 1, "keyframes": {"times": [$times], "values": {
        "position": [0, 2, 3, 1, 2, 3], "target": [0, 0, 0, 0, 0, 0], "fov": [60, 60]}}}]}"""

    @Test
    fun aPathOfSuperSplatIsPlayed() {
        openAndDraw()
        openPath(track())
        moves("path")
        turns()
        touch(MotionEvent.ACTION_DOWN, 0, 320f to 240f)
        moves("")
        touch(MotionEvent.ACTION_UP, 400, 320f to 240f)
    }

    @Test
    fun whatIsNoPathIsSaidInOneLine() {
        openAndDraw()
        for ((text, said) in listOf("no" to "is not JSON", track("30, 0") to "later time", "" to "is not JSON")) {
            ShadowToast.reset()
            openPath(text)
            until("it is said") { ShadowToast.getTextOfLatestToast()?.contains(said) == true }
            assertFalse(ShadowToast.getTextOfLatestToast().contains("\n"))
        }
        settled()
    }

    // Walking

    @Test
    fun oneWalksWithTheStick() {
        openAndDraw()
        assertFalse(activity.isShown(R.id.stick))
        choose(R.string.walk)
        moves("walk")
        until("there is a stick") { activity.isShown(R.id.stick) }
        settled()
        val stick = activity.view(R.id.stick)
        stick.layout(0, 0, 128, 128)
        val before = session.place()!!
        val down = SystemClock.uptimeMillis()
        fun thumb(action: Int, y: Float) = stick.dispatchTouchEvent(MotionEvent.obtain(down, down, action, 64f, y, 0))
        thumb(MotionEvent.ACTION_DOWN, 64f)
        thumb(MotionEvent.ACTION_MOVE, -500f)
        turns()
        thumb(MotionEvent.ACTION_UP, -500f)
        settled()
        assertFalse(before.contentEquals(session.place()!!))
        choose(R.string.walk)
        moves("")
        until("there is none") { !activity.isShown(R.id.stick) }
    }

    // Mouse and keyboard

    private fun wheel(notches: Float) {
        val properties = arrayOf(MotionEvent.PointerProperties().apply { toolType = MotionEvent.TOOL_TYPE_MOUSE })
        val at = MotionEvent.PointerCoords().apply {
            x = 320f
            y = 240f
            setAxisValue(MotionEvent.AXIS_VSCROLL, notches)
        }
        val now = SystemClock.uptimeMillis()
        val event = MotionEvent.obtain(
            now, now, MotionEvent.ACTION_SCROLL, 1, properties, arrayOf(at), 0, 0, 1f, 1f, 0, 0, InputDevice.SOURCE_MOUSE, 0,
        )
        assertTrue(activity.view(R.id.surface).dispatchGenericMotionEvent(event))
    }

    private fun mouse(action: Int, x: Float, buttons: Int) {
        val properties = arrayOf(MotionEvent.PointerProperties().apply { toolType = MotionEvent.TOOL_TYPE_MOUSE })
        val at = MotionEvent.PointerCoords().apply { this.x = x; y = 240f }
        val now = SystemClock.uptimeMillis()
        val event = MotionEvent.obtain(
            now, now, action, 1, properties, arrayOf(at), 0, buttons, 1f, 1f, 0, 0, InputDevice.SOURCE_MOUSE, 0,
        )
        activity.view(R.id.surface).dispatchTouchEvent(event)
        pump()
    }

    private fun distance() = session.place()!![7]

    @Test
    fun theWheelZoomsAndTheRightButtonMoves() {
        openAndDraw()
        val before = session.place()!!
        wheel(1f)
        until("it is nearer") { distance() < 0.9 * before[7] }
        settled()
        val near = session.place()!!
        mouse(MotionEvent.ACTION_DOWN, 320f, MotionEvent.BUTTON_SECONDARY)
        mouse(MotionEvent.ACTION_MOVE, 400f, MotionEvent.BUTTON_SECONDARY)
        pump(500)
        mouse(MotionEvent.ACTION_UP, 400f, 0)
        settled()
        val moved = session.place()!!
        assertTrue("along the image", abs(moved[0] - near[0]) + abs(moved[1] - near[1]) + abs(moved[2] - near[2]) > 0.01)
        for (i in 3..6) assertEquals(near[i], moved[i], 1e-9)
    }

    @Test
    fun keysFlyAndTypeAsOnTheDesktop() {
        openAndDraw()
        val before = session.place()!!
        fun key(action: Int, code: Int, meta: Int = 0) =
            activity.dispatchKeyEvent(KeyEvent(0, SystemClock.uptimeMillis(), action, code, 0, meta))
        assertTrue(key(KeyEvent.ACTION_DOWN, KeyEvent.KEYCODE_W))
        turns()
        key(KeyEvent.ACTION_UP, KeyEvent.KEYCODE_W)
        settled()
        key(KeyEvent.ACTION_DOWN, KeyEvent.KEYCODE_R)
        key(KeyEvent.ACTION_UP, KeyEvent.KEYCODE_R)
        until("it is where it began") { isNear(before) }
        assertFalse("Ctrl is the system's", key(KeyEvent.ACTION_DOWN, KeyEvent.KEYCODE_W, KeyEvent.META_CTRL_ON))
        key(KeyEvent.ACTION_DOWN, KeyEvent.KEYCODE_D)
        activity.view(R.id.surface).onWindowFocusChanged(false)
        settled()
    }

    // What is behind the scene

    @Test
    fun theBackgroundIsChosenAndKept() {
        val few = Documents.offer(File(material, "few.splat")) // which leave much of the image free
        openAndDraw(few)
        assertTrue(whites(settled()) < 0.05)
        chooseView(R.string.backdrop, 3)
        assertTrue(whites(settled()) > 0.2)
        assertEquals(0xFFFFFF, Settings.load(context).backdrop)
        close()
        openAndDraw(few)
        assertTrue(whites(settled()) > 0.2)
    }

    /** The part of the pixels that is white. */
    private fun whites(image: Bitmap): Double {
        val pixels = IntArray(image.width * image.height)
        image.getPixels(pixels, 0, image.width, 0, 0, image.width, image.height)
        return pixels.count { it and 0xFFFFFF == 0xFFFFFF } / pixels.size.toDouble()
    }
}
