package org.fluxgs.app

import android.content.Intent
import android.net.Uri
import android.os.ParcelFileDescriptor
import android.view.View
import android.view.ViewGroup
import java.io.File
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

@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class OpeningTest : ViewerScreen() {
    @Test
    fun theSampleIsDrawnAsTheDesktopDrawsIt() {
        openAndDraw()
        val image = settled()
        keep(image, "sample-scene")
        val found = psnr(image, imageOf("sample.png"))
        assertTrue("$found dB", found > 45)
        assertEquals(0, session.state()!!.dropped)
    }

    @Test
    fun everyFormatOfAnotherAppIsOpenedByItsContent() {
        for (format in listOf("ply", "glb", "spz", "splat")) {
            val file = File(material, "scene.$format")
            val unnamed = file.copyTo(File(context.cacheDir, "document-$format"), true)
            openAndDraw(Documents.offer(unnamed))
            assertEquals(format, session.state()!!.loading.format)
            assertTrue(spread(settled()) > 100)
            close()
        }
    }

    @Test
    fun whatIsSharedToTheAppIsOpened() {
        val uri = Documents.offer(File(material, "scene.spz"))
        start(
            Intent(context, ViewerActivity::class.java).setAction(Intent.ACTION_SEND)
                .putExtra(Intent.EXTRA_STREAM, uri),
        )
        until("the scene is drawn") { session.state()!!.drawn }
        assertEquals("spz", session.state()!!.loading.format)
    }

    @Test
    fun anotherSceneTakesThePlaceOfTheFirst() {
        openAndDraw()
        val first = settled()
        val other = Documents.offer(File(material, "scene.splat"))
        controller!!.newIntent(Intent(context, ViewerActivity::class.java).setData(other))
        until("the other is drawn") { session.state()!!.loading.format == "splat" }
        until("the other is drawn") { session.state()!!.loading.ready && !activity.isShown(R.id.loading) }
        assertTrue(psnr(settled(), first) < 40)
    }

    @Test
    fun loadingIsShownAndCanBeCancelled() {
        Documents.answers["garden.ply"] = { // a pipe in which there is a part of it, and no more
            val mode = ParcelFileDescriptor.MODE_READ_WRITE
            ParcelFileDescriptor.open(File(material, "pipe"), mode)
        }
        Documents.sizes["garden.ply"] = File(material, "scene.ply").length()
        open(Documents.uri("garden.ply"))
        until("it is read") { session.state()!!.loading.phase == "reading" }
        val part = File(material, "scene.ply").inputStream().use { it.readNBytes(1_000_000) }
        fill(File(material, "pipe"), part)
        until("some of it came") { activity.text(R.id.loading_detail).startsWith("1") }
        assertTrue(activity.isShown(R.id.loading_cancel))
        assertTrue("of how much is said, too", " of " in activity.text(R.id.loading_detail))
        assertFalse("there is enough of it", "memory" in activity.text(R.id.loading_detail))
        keep(screenOf(activity, null), "loading")
        press(R.id.loading_cancel)
        assertTrue(activity.isFinishing)
    }

    /** Its .splat has no header that would miss the rest. */
    @Test
    fun aProviderThatDiesInBetweenIsNoPartOfAScene() {
        val whole = File(material, "scene.splat")
        val pipe = File(material, "pipe")
        Documents.answers["garden.splat"] = {
            ParcelFileDescriptor.open(pipe, ParcelFileDescriptor.MODE_READ_ONLY)
        }
        Documents.sizes["garden.splat"] = whole.length()
        val sender = kotlin.concurrent.thread {
            val part = whole.inputStream().use { it.readNBytes(192 * 1024) }
            java.io.FileOutputStream(pipe).use { it.write(part) }
        }
        val message = openAndFail(Documents.uri("garden.splat"))
        sender.join()
        assertEquals(context.getString(R.string.scene_cut), message)
        assertTrue(cause, "ended after 196608 of ${whole.length()} bytes" in cause)
    }

    @Test
    fun aSceneThatCannotBeShownLeadsBackToTheOneBefore() {
        openAndDraw()
        val first = settled()
        val text = File(context.cacheDir, "text.glb").apply { writeText("no scene") }
        val other = Documents.offer(text)
        controller!!.newIntent(Intent(context, ViewerActivity::class.java).setData(other))
        until("the app says that it cannot") { activity.isShown(R.id.loading_leave) }
        press(R.id.loading_leave)
        assertFalse(activity.isFinishing)
        repeat(20) { pump() }
        assertFalse(activity.isShown(R.id.loading))
        assertTrue(psnr(settled(), first) > 45)
    }

    @Test
    fun aProviderThatDoesNotAnswerIsSaidToBeSlow() {
        val gate = java.util.concurrent.CountDownLatch(1)
        Documents.answers["stuck"] = {
            gate.await()
            ParcelFileDescriptor.open(
                File(material, "scene.glb"), ParcelFileDescriptor.MODE_READ_ONLY,
            )
        }
        open(Documents.uri("stuck"))
        pump(SceneOpening.PATIENCE_MS + 1000)
        assertEquals(context.getString(R.string.provider_slow), activity.text(R.id.loading_detail))
        assertTrue("nobody has to wait", activity.isShown(R.id.loading_cancel))
        gate.countDown()
        until("it came all the same") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
    }

    @Test
    fun theProblemOfOneSceneIsNotShownWhileTheNextIsAskedFor() {
        val text = File(context.cacheDir, "text.glb").apply { writeText("no scene") }
        openAndFail(Documents.offer(text))
        val gate = java.util.concurrent.CountDownLatch(1)
        Documents.answers["stuck"] = {
            gate.await()
            ParcelFileDescriptor.open(
                File(material, "scene.glb"), ParcelFileDescriptor.MODE_READ_ONLY,
            )
        }
        val next = Intent(context, ViewerActivity::class.java).setData(Documents.uri("stuck"))
        controller!!.newIntent(next)
        repeat(3) {
            pump(ViewerActivity.LOOK_EVERY_MS)
            assertTrue("nobody has to wait", activity.isShown(R.id.loading_cancel))
            assertFalse(activity.isShown(R.id.loading_retry))
        }
        gate.countDown()
        until("it is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
    }

    @Test
    fun aProviderThatNeverAnswersIsLeftByCancel() {
        val gate = java.util.concurrent.CountDownLatch(1)
        Documents.answers["stuck"] = {
            gate.await()
            throw IllegalStateException("late")
        }
        open(Documents.uri("stuck"))
        pump(SceneOpening.PATIENCE_MS + 1000)
        press(R.id.loading_cancel)
        assertTrue(activity.isFinishing)
        gate.countDown()
        repeat(5) { pump() }
        assertFalse("a late answer changes nothing", activity.isShown(R.id.loading_retry))
    }

    @Test
    fun aFileThatMayNotBeRead() {
        Documents.answers["locked"] = {
            throw java.io.FileNotFoundException("open failed: EACCES (Permission denied)")
        }
        assertEquals(
            context.getString(R.string.scene_forbidden), openAndFail(Documents.uri("locked")),
        )
    }

    @Test
    fun whatIsSharedAndNoFileIsSaidToBe() {
        for (extra in listOf<android.os.Parcelable?>(null, android.graphics.Rect(1, 2, 3, 4))) {
            val intent = Intent(context, ViewerActivity::class.java).setAction(Intent.ACTION_SEND)
            if (extra != null) intent.putExtra(Intent.EXTRA_STREAM, extra)
            start(intent)
            assertEquals(context.getString(R.string.nothing_shared), activity.text(R.id.loading_detail))
            assertFalse("the same would come of it", activity.isShown(R.id.loading_retry))
            close()
        }
        openAndDraw()
        controller!!.newIntent(Intent(context, ViewerActivity::class.java).setAction(Intent.ACTION_SEND))
        assertEquals(context.getString(R.string.nothing_shared), activity.text(R.id.loading_detail))
        press(R.id.loading_leave)
        assertFalse(activity.isFinishing)
        assertFalse(activity.isShown(R.id.loading))
    }

    @Test
    fun everyButtonCanBeReachedInANarrowWindow() {
        openAndDraw()
        val tools = listOf(R.id.reset, R.id.gyroscope, R.id.screenshot, R.id.more).map { activity.view(it) }
        tools.forEach { it.visibility = View.VISIBLE }
        val density = activity.resources.displayMetrics.density
        for (width in listOf(360, 320, 200)) {
            val root = activity.view(R.id.root)
            val exactly = View.MeasureSpec.EXACTLY
            root.measure(
                View.MeasureSpec.makeMeasureSpec((width * density).toInt(), exactly),
                View.MeasureSpec.makeMeasureSpec((640 * density).toInt(), exactly),
            )
            root.layout(0, 0, root.measuredWidth, root.measuredHeight)
            val lefts = tools.map { tool ->
                android.graphics.Rect().also { (root as ViewGroup).offsetDescendantRectToMyCoords(tool, it) }.left
            }
            assertEquals("$width dp: one after the other", lefts.sorted().distinct(), lefts)
            tools.forEach { assertTrue(it.width >= 48 * density - 1) }
            if (width == 360) assertTrue(lefts.last() + tools.last().width <= root.width)
            val motion = activity.view(R.id.motion)
            assertTrue(motion.left >= 0 && motion.right <= root.width && motion.width >= 48 * density - 1)
        }
    }

    @Test
    fun cancellingAnotherSceneLeadsBackToTheFirst() {
        openAndDraw()
        Documents.answers["slow.glb"] = {
            ParcelFileDescriptor.open(File(material, "pipe"), ParcelFileDescriptor.MODE_READ_WRITE)
        }
        controller!!.newIntent(Intent(context, ViewerActivity::class.java).setData(Documents.uri("slow.glb")))
        until("it is read") { session.state()!!.loading.phase == "reading" }
        press(R.id.loading_cancel)
        assertFalse(activity.isFinishing)
        more(R.id.measure)
        assertEquals(Scene.SAMPLE, started().data)
    }

    @Test
    fun aFileThatIsGone() {
        val uri = Documents.uri("nothing")
        assertEquals(context.getString(R.string.moved_or_deleted), openAndFail(uri))
        assertEquals("Can't open My nothing", activity.text(R.id.loading_title))
        more(R.id.measure)
        assertNull("there is nothing to measure", shadowOf(activity).nextStartedActivity)
        pump(200)
        keep(screenOf(activity, null), "cannot-open")
        assertTrue(activity.view(R.id.loading_retry).height > 0)
        assertFalse("who asks sees it", activity.isShown(R.id.loading_cause))
        activity.findViewById<android.widget.CheckBox>(R.id.loading_unfold).isChecked = true
        pump(2 * ViewerActivity.LOOK_EVERY_MS)
        assertTrue(activity.isShown(R.id.loading_cause))
        assertTrue(cause, uri.toString() in cause)
        press(R.id.loading_choose)
        val asked = shadowOf(activity).nextStartedActivityForResult.intent
        assertEquals(Intent.ACTION_OPEN_DOCUMENT, asked.action)
        val other = Documents.offer(File(material, "scene.glb"))
        shadowOf(activity).receiveResult(asked, android.app.Activity.RESULT_OK, Intent().setData(other))
        until("the other is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
    }

    @Test
    fun aFileOfTheAppsOwnFolderThatIsGone() {
        val uri = Uri.fromFile(File(context.filesDir, "nothing.glb"))
        assertEquals(context.getString(R.string.moved_or_deleted), openAndFail(uri))
    }

    /** The copy of the sample that an earlier installation has left, of a format of then perhaps. */
    @Test
    fun theSampleIsOfThisInstallation() {
        File(context.cacheDir, "sample.glb").writeText("as it was")
        File(context.cacheDir, "sample.version").writeText(BuildFacts.version(context) + " of 17")
        openAndDraw()
        val kept = File(context.cacheDir, "sample.version").readText()
        assertEquals(BuildFacts.installed(context), kept)
        openAndDraw()
    }

    @Test
    fun aPermissionThatHasEnded() {
        Documents.answers["private"] = { throw SecurityException("no") }
        val said = openAndFail(Documents.uri("private"))
        assertEquals(context.getString(R.string.scene_forbidden), said)
    }

    @Test
    fun aProviderThatThrowsAnything() {
        Documents.answers["rude"] = { throw IllegalStateException("broken app") }
        assertEquals(context.getString(R.string.scene_unreadable), openAndFail(Documents.uri("rude")))
        assertTrue(cause, "broken app" in cause)
    }

    @Test
    fun aFileThatIsNoScene() {
        val file = File(context.cacheDir, "letter.pdf").apply { writeText("%PDF-1.7 hello") }
        val said = openAndFail(Documents.offer(file))
        assertEquals(context.getString(R.string.scene_broken), said)
        assertTrue(cause, "is a PDF document" in cause)
    }

    @Test
    fun hostileFilesAreTurnedAwayAndTheAppLivesOn() {
        for (name in listOf("cut.glb", "cut.ply", "many.ply", "zeros.spz", "empty.glb", "bomb.sog")) {
            val said = openAndFail(Documents.offer(File(material, name)))
            assertTrue("$name: $said", said.length in 10..400)
            assertTrue("$name: $cause", cause.length in 10..400)
            close()
        }
        openAndDraw()
    }

    @Test
    fun aFileLargerThanTheMemoryIsSaidToBe() {
        val file = File(context.cacheDir, "large.glb")
        java.io.RandomAccessFile(file, "rw").use {
            it.write(File(material, "scene.glb").readBytes())
            it.setLength(2L shl 30)
        }
        memory(600L shl 20)
        val said = openAndFail(Documents.offer(file))
        assertEquals(context.getString(R.string.scene_no_memory), said)
        file.delete()
    }

    @Test
    fun aFileThatWasMendedCanBeTriedAgain() {
        val file = File(context.cacheDir, "mended.glb").apply { writeText("nothing") }
        openAndFail(Documents.offer(file))
        File(material, "scene.glb").copyTo(file, true)
        press(R.id.loading_retry)
        until("the scene is drawn") { session.state()!!.drawn }
    }
}
