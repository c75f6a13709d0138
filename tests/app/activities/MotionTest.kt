package org.fluxgs.app

import android.view.MenuItem
import android.view.MotionEvent
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowPopupMenu

/** What moves the view by itself. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class MotionTest : ViewerScreen() {
    private fun entry(label: Int): MenuItem {
        press(R.id.motion)
        val menu = ShadowPopupMenu.getLatestPopupMenu().menu
        val text = context.getString(label)
        return (0 until menu.size()).map { menu.getItem(it) }.first { it.title == text }
    }

    private fun choose(label: Int) {
        val menu = ShadowPopupMenu.getLatestPopupMenu()
        val item = entry(label)
        assertTrue(ShadowPopupMenu.getLatestPopupMenu().menu.performIdentifierAction(item.itemId, 0))
        assertFalse(menu === ShadowPopupMenu.getLatestPopupMenu())
        pump()
    }

    private fun turns(): Boolean {
        val before = session.place()!!
        repeat(60) { pump() }
        return !before.contentEquals(session.place()!!)
    }

    private fun moves(how: String) = until("it is '$how'") { session.state()!!.motion == how }

    // Auto-orbit

    @Test
    fun aSceneTurnsFromTheStartUntilItIsTouched() {
        animations(1f)
        openAndDraw()
        moves("drift")
        assertTrue(turns())
        touch(MotionEvent.ACTION_DOWN, 0, 320f to 240f)
        touch(MotionEvent.ACTION_UP, 400, 320f to 240f)
        moves("")
        assertFalse(turns())
    }

    @Test
    fun theMenuStartsAndStopsIt() {
        openAndDraw()
        assertFalse(entry(R.string.auto_orbit).isChecked)
        choose(R.string.auto_orbit)
        moves("drift")
        assertTrue(entry(R.string.auto_orbit).isChecked)
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
        Settings(scale = 1f, sorter = 2, autoOrbit = false).save(context)
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
}
