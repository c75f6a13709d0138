package org.fluxgs.app

import android.content.Intent
import android.net.Uri
import android.os.ParcelFileDescriptor
import java.io.File
import java.util.concurrent.CountDownLatch
import org.junit.After
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNull
import org.junit.Assert.assertTrue
import org.junit.Before
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.android.controller.ActivityController
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowToast

/** Several scenes that another app shares at once. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w411dp-h731dp-port-hdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class AddScenesTest {
    private val context = RuntimeEnvironment.getApplication()
    private var controller: ActivityController<AddScenesActivity>? = null
    private val activity get() = controller!!.get()
    private val kept get() = Library(context).copies.list()!!.sorted()

    @Before
    fun offerDocuments() {
        Documents.install()
        Library(context).copies.mkdirs()
    }

    @After
    fun close() {
        controller?.end()
        controller = null
    }

    private fun intentOf(vararg uris: Uri) = Intent(context, AddScenesActivity::class.java)
        .setAction(Intent.ACTION_SEND_MULTIPLE).setType("*/*")
        .putParcelableArrayListExtra(Intent.EXTRA_STREAM, ArrayList(uris.asList()))

    private fun share(vararg uris: Uri) {
        controller = Robolectric.buildActivity(AddScenesActivity::class.java, intentOf(*uris)).setup()
    }

    private fun offer(name: String) = Documents.offer(File(material, name))

    private fun failed(): String {
        until("it is said") { activity.isShown(R.id.loading_leave) }
        return activity.text(R.id.loading_detail)
    }

    private fun press(id: Int) {
        activity.view(id).performClick()
        pump()
    }

    @Test
    fun allOfThemComeIntoTheList() {
        share(offer("scene.spz"), offer("scene.splat"), offer("scene.glb"))
        until("they are there") { activity.isFinishing }
        assertEquals(listOf("My scene.glb", "My scene.splat", "My scene.spz"), kept)
        assertEquals("Scenes added: 3 of 3", ShadowToast.getTextOfLatestToast())
        assertEquals(ScenesActivity::class.java.name, shadowOf(activity).nextStartedActivity.component!!.className)
        assertEquals(3, Recents(context).all().size)
    }

    @Test
    fun oneIsOpened() {
        share(offer("scene.spz"))
        until("it is there") { activity.isFinishing }
        val opened = shadowOf(activity).nextStartedActivity
        assertEquals(ViewerActivity::class.java.name, opened.component!!.className)
        assertTrue(Library(context).owns(opened.data!!))
    }

    @Test
    fun thoseThatFailAreNamedAndCanBeTriedAgain() {
        val letter = File(context.cacheDir, "letter.pdf").apply { writeText("%PDF-1.7 hello") }
        Documents.answers.remove("late.spz")
        share(Documents.offer(letter), offer("scene.spz"), Documents.uri("late.spz"))
        assertEquals(context.getString(R.string.not_added, "My letter.pdf, My late.spz"), failed())
        assertEquals("Scenes added: 1 of 3", activity.text(R.id.loading_title))
        val why = activity.text(R.id.loading_cause)
        assertTrue(why, context.getString(R.string.scene_broken) in why && context.getString(R.string.copy_gone) in why)
        keep(screenOf(activity, null), "not-added")
        assertEquals("nothing is left of the others", listOf("My scene.spz"), kept)
        Documents.answers["late.spz"] = Documents.answers.getValue("scene.spz")
        Documents.answers["letter.pdf"] = Documents.answers.getValue("scene.spz")
        press(R.id.loading_retry)
        until("they are there") { activity.isFinishing }
        assertEquals(3, kept.size)
    }

    @Test
    fun howFarItIsIsShownAndWhatIsNotWholeIsLeftByCancel() {
        val pipe = File(material, "pipe")
        Documents.answers["garden.ply"] = { // a pipe in which there is a part of it, and no more
            ParcelFileDescriptor.open(pipe, ParcelFileDescriptor.MODE_READ_WRITE)
        }
        Documents.sizes["garden.ply"] = File(material, "scene.ply").length()
        share(offer("scene.spz"), Documents.uri("garden.ply"))
        until("the second comes") { activity.text(R.id.loading_title).startsWith("2 of 2") }
        val part = File(material, "scene.ply").inputStream().use { it.readNBytes(1_000_000) }
        fill(pipe, part)
        until("some of it came") { " of " in activity.text(R.id.loading_detail) }
        assertTrue(activity.text(R.id.loading_title).endsWith("Adding My garden"))
        keep(screenOf(activity, null), "adding")
        press(R.id.loading_cancel)
        assertTrue(activity.isFinishing)
        fill(pipe, ByteArray(100)) // so that its thread ends
        until("nothing is left of it") { kept == listOf("My scene.spz") }
        Documents.sizes.clear()
    }

    @Test
    fun nothingThatCanBeOpenedIsSaidToBe() {
        for (uris in listOf(emptyList(), listOf(Uri.parse("file:///data/secret.glb"), Uri.parse("nonsense")))) {
            share(*uris.toTypedArray())
            assertEquals(context.getString(R.string.nothing_shared), failed())
            assertFalse(activity.isShown(R.id.loading_retry))
            close()
        }
        controller = Robolectric.buildActivity(
            AddScenesActivity::class.java,
            intentOf().putParcelableArrayListExtra(Intent.EXTRA_STREAM, arrayListOf(android.graphics.Rect())),
        ).setup()
        assertEquals(context.getString(R.string.nothing_shared), failed())
    }

    @Test
    fun whatIsSharedMeanwhileComesAfterwards() {
        val first = offer("scene.spz")
        val gate = CountDownLatch(1)
        val answer = Documents.answers.getValue("scene.spz")
        Documents.answers["scene.spz"] = {
            gate.await()
            answer()
        }
        share(first)
        until("it is asked for") { SceneCopy.of(first) != null }
        controller!!.newIntent(intentOf(first, offer("scene.glb")))
        gate.countDown()
        until("both are there") { activity.isFinishing }
        assertEquals("the same one once", listOf("My scene.glb", "My scene.spz"), kept)
    }

    private fun takes(action: String, uri: Uri?, type: String?): Set<String> {
        val intent = Intent(action).setDataAndType(uri, type)
        return context.packageManager.queryIntentActivities(intent, 0).map { it.activityInfo.name.substringAfterLast('.') }.toSet()
    }

    @Test
    fun scenesAreTakenByTypeOrByTheEndOfTheirNameAndNothingElseIs() {
        fun view(path: String) = takes(Intent.ACTION_VIEW, Uri.parse("content://files/$path"), "text/plain")
        for (name in listOf("a.ply", "b/garden.v2.spz", "primary%3ADownload%2Fa.b.c.splat", "x.sog", "x.glb"))
            assertEquals(name, setOf("ViewerActivity"), view(name))
        for (name in listOf("letter.pdf", "a.ply.txt", "17")) assertEquals(name, emptySet<String>(), view(name))
        assertEquals(setOf("ViewerActivity"), takes(Intent.ACTION_VIEW, Uri.parse("content://files/17"), "model/gltf-binary"))
        assertEquals(setOf("AddScenesActivity"), takes(Intent.ACTION_SEND_MULTIPLE, null, "*/*"))
        assertEquals(emptySet<String>(), takes(Intent.ACTION_SEND_MULTIPLE, null, "image/png"))
    }

    @Test
    fun theTimeLeftIsThatOfTheLastSeconds() {
        val left = TimeLeft()
        fun at(seconds: Int, done: Long, all: Long = 1000) = left.seconds(1000L * seconds, done, all)
        assertNull(at(0, 0))
        assertNull("too little to go by", at(1, 100))
        assertEquals(8L, at(2, 200))
        assertNull("nobody knows how much", at(3, 210, -1))
        for (second in 4..13) at(second, 200L + second)
        assertEquals("it has become slow", 786L, at(14, 214))
        for (second in 15..30) at(second, 214)
        assertNull("it stands still", at(31, 214))
        assertNull("another one", at(32, 5))
        assertEquals(99L, at(42, 105, 1095))
    }
}
