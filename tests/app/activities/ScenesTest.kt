package org.fluxgs.app

import android.app.Activity
import android.content.Intent
import android.content.pm.ConfigurationInfo
import android.net.Uri
import android.view.View
import android.view.ViewGroup
import android.widget.GridView
import android.widget.ImageView
import android.widget.TextView
import java.io.File
import java.util.Locale
import org.junit.After
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNotNull
import org.junit.Assert.assertNull
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.android.controller.ActivityController
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowAlertDialog
import org.robolectric.shadows.ShadowPopupMenu
import org.robolectric.shadows.ShadowToast

@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w411dp-h731dp-port-hdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class ScenesTest {
    private val context = RuntimeEnvironment.getApplication()
    private var controller: ActivityController<ScenesActivity>? = null
    private val activity get() = controller!!.get()
    private val grid get() = activity.view(R.id.grid) as GridView

    private fun open() {
        controller = Robolectric.buildActivity(ScenesActivity::class.java).setup()
        listRead()
    }

    private fun listRead() {
        Background.start {}.get()
        pump()
    }

    private val locale = Locale.getDefault()

    @After
    fun speakAsBefore() = Locale.setDefault(locale)

    @After
    fun close() {
        controller?.end()
        controller = null
    }

    @Test
    fun aDeviceWithoutOpenGlSaysSoAtTheStart() {
        open()
        assertFalse("nobody knows", activity.isShown(R.id.problem))
        close()
        val manager = context.getSystemService(android.app.ActivityManager::class.java)
        for ((version, told) in listOf(0x20000 to true, 0x30000 to true, 0x30001 to false, 0x30002 to false)) {
            val facts = ConfigurationInfo().apply { reqGlEsVersion = version }
            shadowOf(manager).setDeviceConfigurationInfo(facts)
            open()
            assertEquals(told, activity.isShown(R.id.problem))
            close()
        }
    }

    private fun tap(position: Int) {
        grid.performItemClick(grid.getChildAt(position), position, grid.adapter.getItemId(position))
    }

    private fun name(position: Int): String =
        grid.getChildAt(position).findViewById<TextView>(R.id.name).text.toString()

    private fun remember(name: String, image: String): Uri {
        val uri = Documents.uri(name)
        val place = DoubleArray(12) { it.toDouble() }
        Recents(context).remember(uri, name, 1_500_000, 123_456, place, imageOf(image))
        return uri
    }

    @Test
    fun theSampleIsThereFromTheStart() {
        open()
        assertEquals(1, grid.adapter.count)
        assertEquals(context.getString(R.string.sample_scene), name(0))
        val picture = grid.getChildAt(0).findViewById<ImageView>(R.id.image).drawable
        assertEquals("its picture, before it was opened", 256, picture.intrinsicWidth)
        tap(0)
        val next = shadowOf(activity).nextStartedActivity
        assertEquals(ViewerActivity::class.java.name, next.component!!.className)
        assertEquals(Scene.SAMPLE, next.data)
    }

    @Test
    fun scenesThatWereOpenedComeWithTheirImagesTheNewestFirst() {
        remember("corner.glb", "shown_corner.png")
        val uri = remember("marbles.ply", "shown_marbles.png")
        Recents(context).remember(
            Scene.SAMPLE, "Sample scene", 282_968, 28_842, null, imageOf("sample.png"),
        )
        open()
        assertEquals(3, grid.adapter.count)
        assertEquals("marbles", name(1))
        assertEquals("corner", name(2))
        assertNotNull(grid.getChildAt(1).findViewById<ImageView>(R.id.image).drawable)
        assertTrue(grid.getChildAt(1).contentDescription.startsWith("marbles, ${Texts.short(123_456)} splats · 1.5 MB · "))
        keep(screenOf(activity, null), "scenes")
        tap(1)
        assertEquals(uri, shadowOf(activity).nextStartedActivity.data)
    }

    @Test
    fun scenesThatWereSentByAdbAreThere() {
        val own = context.getExternalFilesDir(null)!!
        val sent = java.io.File(own, "garden.PLY").apply { writeBytes(ByteArray(2_500_000)) }
        java.io.File(own, "garden.json").writeText("{}")
        open()
        assertEquals(2, grid.adapter.count)
        assertEquals("garden", name(1))
        assertTrue(grid.getChildAt(1).contentDescription.endsWith("2.5 MB"))
        tap(1)
        val uri = shadowOf(activity).nextStartedActivity.data!!
        assertEquals(Uri.fromFile(sent), uri)
        close()
        Recents(context).remember(uri, "garden.PLY", 2_500_000, 10_000, null, null)
        open()
        assertEquals("once", 2, grid.adapter.count)
        assertTrue(grid.getChildAt(1).contentDescription.contains("splats"))
        sent.delete()
    }

    @Test
    fun theSystemsPickerGivesScenesOfAnyName() {
        open()
        activity.view(R.id.open).performClick()
        val asked = shadowOf(activity).nextStartedActivityForResult
        assertEquals(Intent.ACTION_OPEN_DOCUMENT, asked.intent.action)
        assertEquals("*/*", asked.intent.type)
        assertTrue(asked.intent.hasCategory(Intent.CATEGORY_OPENABLE))
        val uri = Documents.uri("picked.bin")
        shadowOf(activity).receiveResult(asked.intent, Activity.RESULT_OK, Intent().setData(uri))
        assertEquals(uri, shadowOf(activity).nextStartedActivity.data)
        val kept = context.contentResolver.persistedUriPermissions
        assertTrue("it may be read after a restart", kept.any { it.uri == uri && it.isReadPermission })
    }

    @Test
    fun permissionsOfScenesThatAreInNoListAreLetGoOfAfterADay() {
        val (wanted, other) = listOf(Documents.uri("wanted.glb"), Documents.uri("other.glb"))
        UriPermissions.keep(context, wanted)
        UriPermissions.keep(context, other)
        val kept = { context.contentResolver.persistedUriPermissions.map { it.uri }.toSet() }
        open() // may be while the other is read still
        pump()
        Background.start {}.get()
        assertEquals(setOf(wanted, other), kept())
        UriPermissions.releaseAllBut(context, setOf(wanted), System.currentTimeMillis() + 25 * 3_600_000L)
        assertEquals(setOf(wanted), kept())
    }

    @Test
    fun nothingPickedIsNothingOpened() {
        open()
        activity.view(R.id.open).performClick()
        val asked = shadowOf(activity).nextStartedActivityForResult
        shadowOf(activity).receiveResult(asked.intent, Activity.RESULT_CANCELED, null)
        val started = generateSequence { shadowOf(activity).nextStartedActivity }
        assertTrue(started.all { it.action == Intent.ACTION_OPEN_DOCUMENT })
    }

    @Test
    fun aDeviceWithoutAPickerSaysSo() {
        shadowOf(context).checkActivities(true)
        open()
        activity.view(R.id.open).performClick()
        assertEquals(context.getString(R.string.no_picker), ShadowToast.getTextOfLatestToast())
    }

    @Test
    fun aListThatIsDamagedIsAnEmptyOne() {
        File(context.filesDir, "recents").mkdirs()
        File(context.filesDir, "recents/list.json").writeText("[{\"uri\": 3}, {\"nothing\": 1}, 7, ")
        open()
        assertEquals(1, grid.adapter.count)
        File(context.filesDir, "recents/list.json").writeText("[7, {\"nothing\": 1}, {\"uri\": \"a:b\"}]")
        controller!!.pause().resume()
        listRead()
        assertEquals(2, grid.adapter.count)
    }

    @Test
    fun theListForgetsTheOldest() {
        for (i in 0 until Recents.MOST + 3) remember("scene-$i", "sample.png")
        val all = Recents(context).all()
        assertEquals(Recents.MOST, all.size)
        assertEquals("scene-${Recents.MOST + 2}", all.first().name)
        assertEquals(Recents.MOST, File(context.filesDir, "recents").list()!!.count { it.endsWith(".jpg") })
    }

    @Test
    fun theBenchmarkAndTheVersionAreInTheMenu() {
        open()
        choose(R.id.benchmark)
        val next = shadowOf(activity).nextStartedActivity
        assertEquals(BenchmarkActivity::class.java.name, next.component!!.className)
        choose(R.id.about)
        val said = ShadowAlertDialog.getLatestAlertDialog().findViewById<TextView>(android.R.id.message).text
        assertTrue(BuildFacts.version(context) in said)
    }

    @Test
    fun theListSpeaksTheLanguageOfTheDevice() {
        for ((language, title, today) in listOf(
            Triple("de", "Szenen", "heute"), Triple("fr", "Scènes", "aujourd’hui"),
            Triple("es", "Escenas", "hoy"), Triple("ja", "シーン", "今日"), Triple("zh-rCN", "场景", "今天"),
        )) {
            RuntimeEnvironment.setQualifiers("+$language")
            Locale.setDefault(Locale.forLanguageTag(language.replace("-r", "-"))) // as Android does
            Recents(context).remember(Scene.SAMPLE, "", 282_000, 28_842, null, imageOf("sample.png"))
            open()
            val words = ArrayList<View>()
            activity.window.decorView.findViewsWithText(words, title, View.FIND_VIEWS_WITH_TEXT)
            assertTrue(language, words.size > 0)
            val detail = grid.getChildAt(0).findViewById<TextView>(R.id.detail).text.toString()
            assertTrue(detail, detail.endsWith(today))
            assertFalse("numbers, too: $detail", "29K" in detail)
            keep(screenOf(activity, null), "scenes-$language")
            close()
        }
    }

    private fun choose(id: Int) {
        activity.view(R.id.more).performClick()
        ShadowPopupMenu.getLatestPopupMenu().menu.performIdentifierAction(id, 0)
        pump()
    }

    @Test
    fun theListIsSortedAsPeopleChooseAndStaysSo() {
        for ((name, bytes) in listOf("b.glb" to 2L, "C.glb" to 3L, "a.glb" to 1L)) {
            Recents(context).remember(Documents.uri(name), name, bytes, 1, null, null)
            Thread.sleep(2)
        }
        open()
        fun names() = (1..3).map { name(it) }
        assertEquals(listOf("a", "C", "b"), names())
        for ((id, order) in listOf(
            R.id.by_name to listOf("a", "b", "C"), R.id.by_size to listOf("C", "b", "a"),
        )) {
            choose(id)
            listRead()
            assertEquals(order, names())
        }
        close()
        open()
        assertEquals(listOf("C", "b", "a"), names())
    }

    private fun inAWindowOf(size: String) {
        RuntimeEnvironment.setQualifiers("+$size")
        remember("corner.glb", "shown_corner.png")
        remember("marbles.ply", "shown_marbles.png")
        open()
    }

    @Test
    fun aTabletShowsTheSelectedSceneBesideTheList() {
        inAWindowOf("sw800dp-w1280dp-h800dp-land-mdpi")
        assertEquals("the newest at first", "marbles", activity.text(R.id.pane_name))
        assertTrue(activity.text(R.id.pane_facts).startsWith("123,456 splats · 1.5 MB\n"))
        listRead()
        keep(screenOf(activity, null), "scenes-tablet")
        tap(2)
        listRead()
        assertEquals("corner", activity.text(R.id.pane_name))
        assertNull("it is not opened yet", shadowOf(activity).nextStartedActivity)
        assertTrue(grid.isItemChecked(2))
        activity.view(R.id.pane_open).performClick()
        assertEquals(Documents.uri("corner.glb"), shadowOf(activity).nextStartedActivity.data)
        tap(2)
        assertEquals("a second tap opens it", Documents.uri("corner.glb"), shadowOf(activity).nextStartedActivity.data)
        activity.view(R.id.pane_image).performClick()
        assertEquals("so does one on the picture", Documents.uri("corner.glb"), shadowOf(activity).nextStartedActivity.data)
    }

    private fun choices() = (activity.view(R.id.pane_choices) as ViewGroup).let { all ->
        (0 until all.childCount).map { all.getChildAt(it) as TextView }.filter { it.isShown }
    }

    @Test
    fun itsButtonsAreThoseOfItsMenu() {
        inAWindowOf("sw800dp-w1280dp-h800dp-land-mdpi")
        assertEquals(
            listOf(R.string.show_scene, R.string.keep_copy, R.string.rename, R.string.share, R.string.forget)
                .map { context.getString(it) },
            choices().map { it.text.toString() },
        )
        choices().last().performClick()
        ShadowAlertDialog.getLatestAlertDialog().getButton(android.app.AlertDialog.BUTTON_POSITIVE).performClick()
        repeat(3) { listRead() }
        assertEquals("another is selected", "corner", activity.text(R.id.pane_name))
        tap(0)
        assertEquals(listOf(R.string.show_scene, R.string.share).map { context.getString(it) }, choices().map { it.text.toString() })
    }

    @Test
    fun whatIsSelectedStaysSoWhenTheDeviceIsTurned() {
        inAWindowOf("w731dp-h411dp-land-hdpi")
        tap(2)
        listRead()
        keep(screenOf(activity, null), "scenes-landscape")
        val open = android.graphics.Rect()
        assertTrue(activity.view(R.id.pane_open).getGlobalVisibleRect(open))
        assertEquals("to be seen at once", activity.view(R.id.pane_open).height, open.height())
        controller!!.recreate()
        listRead()
        assertEquals("corner", activity.text(R.id.pane_name))
        RuntimeEnvironment.setQualifiers("+w411dp-h731dp-port")
        controller!!.recreate()
        listRead()
        tap(1)
        assertEquals("a phone upright opens it at once", Documents.uri("marbles.ply"), shadowOf(activity).nextStartedActivity.data)
    }

    /** In a narrow pane and in any language. */
    @Test
    fun theButtonsOfTheSelectedSceneHaveRoom() {
        RuntimeEnvironment.setQualifiers("+de")
        inAWindowOf("w600dp-h400dp-land-mdpi")
        val pane = activity.view(R.id.pane_choices)
        assertTrue("in several lines", choices().map { it.top }.distinct().size > 1)
        for (choice in choices()) {
            assertTrue(choice.text.toString(), choice.left >= 0 && choice.right <= pane.width && choice.bottom <= pane.height)
            assertTrue("one line of text", choice.lineCount == 1)
        }
        assertTrue(activity.view(R.id.pane_image).height >= 80)
    }
}
