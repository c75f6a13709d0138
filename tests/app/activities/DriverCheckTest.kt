package org.fluxgs.app

import android.app.AlertDialog
import android.content.Context
import android.widget.TextView
import org.json.JSONObject
import org.junit.After
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertTrue
import org.junit.Before
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowAlertDialog
import org.robolectric.shadows.ShadowPopupMenu

/** The check of the graphics driver: once, kept, and after a driver that ends the app. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w411dp-h731dp-port-hdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class DriverCheckTest : ViewerScreen() {
    private val kept get() = context.getSharedPreferences("driver", Context.MODE_PRIVATE)

    @Before
    @After
    fun asInANewProcess() = DriverCheck.forget()

    private fun checked() = DriverCheck.of(context)!!

    /** [count] processes before this one were ended while they checked. */
    private fun died(count: Int) {
        checked() // now they know which app and system it is
        kept.edit().remove("check").putInt("deaths", count).commit()
        DriverCheck.forget()
    }

    private fun isPlainest(check: DriverCheck) = !check.right && check.limits.size == 4

    @Test
    fun thisDriverIsRight() {
        val check = checked()
        assertTrue(check.faults.toString(), check.right)
        assertEquals(emptyList<String>(), check.limits)
        assertTrue("${check.psnr} dB", check.psnr > 50)
        assertTrue(check.renderer.isNotEmpty() && check.version.isNotEmpty())
        assertEquals(0, kept.getInt("deaths", -1))
    }

    @Test
    fun itIsCheckedOnceForADriver() {
        checked()
        kept.edit().putString("check", DriverCheck.now!!.json.put("psnr", 47.5).toString()).commit()
        DriverCheck.forget()
        assertEquals("not drawn again", 47.5, checked().psnr, 0.0)
        val drawn = DriverCheck.of(context, anew = true)!!
        assertTrue("${drawn.psnr} dB", drawn.psnr > 50)
    }

    @Test
    fun anotherDriverIsCheckedAgain() {
        checked()
        val other = JSONObject().put("renderer", "Adreno 1").put("version", "2").put("right", false)
        kept.edit().putString("check", other.toString()).commit()
        DriverCheck.forget()
        assertTrue(checked().right)
    }

    @Test
    fun whatIsKeptAndBrokenIsCheckedAgain() {
        checked()
        kept.edit().putString("check", "{\"right\":").commit()
        DriverCheck.forget()
        assertTrue(checked().right)
    }

    @Test
    fun oneDeathMayBeAPersonsButNotTwo() {
        died(1)
        assertTrue(checked().right)
        died(2)
        assertTrue(isPlainest(checked()))
        assertTrue("it is asked to try", DriverCheck.of(context, anew = true)!!.right)
        DriverCheck.forget()
        assertTrue("and has not died", checked().right)
    }

    @Test
    fun anotherInstallationTriesAgain() {
        died(2)
        kept.edit().putString("of", "an older app").commit()
        assertTrue(checked().right)
    }

    @Test
    fun theViewerDoesWithoutWhatFails() {
        died(2)
        openAndDraw(Scene.SAMPLE)
        val driver = session.driver()!!
        assertTrue(driver.getJSONArray("quirks").toString().contains("gpu_sort_fails"))
        assertEquals(0, driver.getInt("max_vertex_storage_blocks"))
        assertFalse(driver.getBoolean("half_float_targets"))
        assertFalse(driver.getBoolean("compute"))
    }

    @Test
    fun aWrongDriverIsNamedAtTheStartAndInAbout() {
        died(2)
        val controller = Robolectric.buildActivity(ScenesActivity::class.java).setup()
        val activity = controller.get()
        until("the problem is told") { activity.isShown(R.id.problem) }
        assertTrue(activity.text(R.id.problem).contains("ended the app"))
        activity.view(R.id.more).performClick()
        ShadowPopupMenu.getLatestPopupMenu().menu.performIdentifierAction(R.id.about, 0)
        val dialog = ShadowAlertDialog.getLatestDialog() as AlertDialog
        val message = dialog.findViewById<TextView>(android.R.id.message).text.toString()
        assertTrue(message, message.contains("ended the app") && message.contains("Version"))
        dialog.dismiss()
        controller.end()
    }

    @Test
    fun aboutSaysHowNearThePictureIs() {
        checked()
        assertTrue(DriverCheck.textOf(context), DriverCheck.textOf(context).contains(" dB"))
        DriverCheck.forget()
        assertEquals(context.getString(R.string.driver_unchecked), DriverCheck.textOf(context))
    }
}
