package org.fluxgs.app

import android.app.AlertDialog
import android.content.Intent
import android.net.Uri
import android.os.ParcelFileDescriptor
import android.view.View
import android.widget.EditText
import android.widget.GridView
import android.widget.TextView
import java.io.File
import java.io.FileOutputStream
import java.nio.file.Files
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
import org.robolectric.Shadows.shadowOf
import org.robolectric.android.controller.ActivityController
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowAlertDialog
import org.robolectric.shadows.ShadowPopupMenu
import org.robolectric.shadows.ShadowToast

/** Scenes that the app keeps itself. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class LibraryTest : ViewerScreen() {
    private val library get() = Library(context)
    private val notice get() = activity.view(R.id.copy)
    private var list: ActivityController<ScenesActivity>? = null
    private val scenes get() = list!!.get()
    private val grid get() = scenes.view(R.id.grid) as GridView

    @After
    fun closeList() {
        list?.end()
        list = null
    }

    private fun openAnother(name: String = "garden.glb"): Uri {
        val file = File(context.cacheDir, name)
        if (!file.exists()) File(material, "scene.glb").copyTo(file)
        val uri = Documents.offer(file)
        start(Intent(Intent.ACTION_VIEW, uri, context, ViewerActivity::class.java))
        until("the scene is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        return uri
    }

    private fun openAndKeep(name: String = "garden.glb"): Uri {
        val uri = openAnother(name)
        until("a copy is offered") { notice.isShown }
        press(notice, R.id.notice_yes)
        until("it is kept") { SceneCopy.of(uri) == null && !notice.isShown }
        return uri
    }

    private fun press(view: View, id: Int) {
        view.findViewById<View>(id).performClick()
        pump()
    }

    /** What is done in the background may lead to more there. */
    private fun settle() = repeat(3) {
        Background.start {}.get()
        pump()
    }

    private fun openList() {
        list = Robolectric.buildActivity(ScenesActivity::class.java).setup()
        settle()
    }

    private fun choose(position: Int, id: Int) {
        grid.getChildAt(position).findViewById<View>(R.id.menu).performClick()
        val item = ShadowPopupMenu.getLatestPopupMenu().menu
        assertTrue("it is offered", item.findItem(id).isVisible)
        item.performIdentifierAction(id, 0)
        pump()
    }

    private fun offered(position: Int): List<Int> {
        grid.getChildAt(position).findViewById<View>(R.id.menu).performClick()
        val menu = ShadowPopupMenu.getLatestPopupMenu().menu
        return (0 until menu.size()).map { menu.getItem(it) }.filter { it.isVisible }.map { it.itemId }
    }

    private fun answer(dialog: AlertDialog = ShadowAlertDialog.getLatestAlertDialog()) {
        dialog.getButton(AlertDialog.BUTTON_POSITIVE).performClick()
        pump()
        settle()
    }

    private fun name(position: Int) =
        grid.getChildAt(position).findViewById<TextView>(R.id.name).text.toString()

    @Test
    fun aSceneThatIsKeptIsOpenedAgainWithoutTheAppItCameFrom() {
        val uri = openAnother()
        until("a copy is offered") { notice.isShown }
        val said = notice.findViewById<TextView>(R.id.notice_text).text
        assertTrue("with its size", Texts.size(context, File(material, "scene.glb").length()) in said)
        keep(screenOf(activity, settled()), "keep-a-copy")
        SavedViews(context, uri).add(session.place()!!)
        press(notice, R.id.notice_yes)
        until("it is kept") { SceneCopy.of(uri) == null && !notice.isShown }
        val before = settled()
        val place = session.place()!!
        settle()
        close()
        Documents.answers.clear() // the other app gives it no more
        val kept = Recents(context).find(uri)!!
        assertTrue(library.owns(kept.uri))
        assertEquals("with the views that were saved", 1, SavedViews(context, kept.uri).all().size)
        assertEquals(File(material, "scene.glb").length(), File(kept.uri.path!!).length())
        openAndDraw(kept.uri)
        assertEquals("My garden", activity.text(R.id.title))
        assertEquals("from where it was looked at", place[7], session.place()!![7], 1e-6)
        assertTrue(psnr(before, settled()) > 45)
        assertFalse("it is kept", notice.isShown)
    }

    /** The same file by "open with" again. */
    @Test
    fun whatIsKeptOrNotWantedIsNotAskedAbout() {
        val uri = openAndKeep()
        settle()
        close()
        openAnother()
        settle()
        assertFalse(notice.isShown)
        controller!!.pause()
        settle()
        assertEquals("it is one scene", 1, Recents(context).all().count { it.uri == uri || it.source == uri })
        close()
        openAnother("pond.glb")
        until("a copy is offered") { notice.isShown }
        press(notice, R.id.notice_no)
        settle()
        close()
        openAnother("pond.glb")
        settle()
        assertFalse("nobody is asked twice", notice.isShown)
    }

    @Test
    fun theSampleIsNotOffered() {
        openAndDraw()
        settle()
        assertFalse(notice.isShown)
    }

    // What can go wrong

    private fun copy(uri: Uri, name: String = "My garden.glb"): SceneCopy.End {
        var end: SceneCopy.End? = null
        SceneCopy.start(context, uri, name).onEnd { end = it }
        until("the copy has ended") { end != null }
        return end!!
    }

    private fun failed(uri: Uri): String {
        val message = (copy(uri) as SceneCopy.Failed).message
        assertTrue("nothing is left of it", library.copies.list().isNullOrEmpty())
        assertTrue("the list is as it was", Recents(context).all().isEmpty())
        return message
    }

    @Test
    fun storageThatIsFullIsSaidToBeAndNothingIsLeft() {
        library.copies.mkdirs()
        val uri = Documents.offer(File(material, "scene.glb"))
        Files.createSymbolicLink(File(library.copies, "My garden.glb.part").toPath(), File("/dev/full").toPath())
        val message = failed(uri)
        assertTrue(message, Texts.size(context, File(material, "scene.glb").length()) in message)
        assertTrue(copy(uri) is SceneCopy.Kept)
    }

    @Test
    fun aSceneThatStorageHasNoRoomForIsNotBegun() {
        val large = File(context.cacheDir, "large.ply")
        java.io.RandomAccessFile(large, "rw").use { it.setLength(1L shl 43) }
        val message = failed(Documents.offer(large))
        assertTrue(message, Texts.size(context, large.length()) in message)
        large.delete()
    }

    @Test
    fun aFileThatGrowsOrEndsEarlyIsNotKept() {
        val pipe = File(material, "pipe")
        for ((sent, said) in listOf(5000 to R.string.copy_cut, 20000 to R.string.copy_grows)) {
            Documents.answers["growing"] = {
                ParcelFileDescriptor.open(pipe, ParcelFileDescriptor.MODE_READ_ONLY)
            }
            Documents.sizes["growing"] = 10000
            val sender = kotlin.concurrent.thread {
                try {
                    FileOutputStream(pipe).use { it.write(ByteArray(sent)) }
                } catch (_: java.io.IOException) {
                    // nobody reads on
                }
            }
            assertEquals(context.getString(said), failed(Documents.uri("growing")))
            sender.join()
        }
    }

    @Test
    fun aFileThatIsGoneOrForbiddenIsSaidToBe() {
        assertEquals(context.getString(R.string.copy_gone), failed(Documents.uri("gone.glb")))
        Documents.answers["private.glb"] = { throw SecurityException("no") }
        assertEquals(context.getString(R.string.scene_forbidden), failed(Documents.uri("private.glb")))
        Documents.answers["rude.glb"] = { throw IllegalStateException("broken app") }
        assertEquals(context.getString(R.string.copy_gone), failed(Documents.uri("rude.glb")))
    }

    @Test
    fun aCopyThatStallsIsLeftByCancel() {
        val uri = openAnother()
        Documents.answers["garden.glb"] = { // a pipe into which nobody writes
            ParcelFileDescriptor.open(File(material, "pipe"), ParcelFileDescriptor.MODE_READ_WRITE)
        }
        until("a copy is offered") { notice.isShown }
        press(notice, R.id.notice_yes)
        until("its progress is shown") { notice.findViewById<View>(R.id.notice_bar).isShown }
        assertNotNull(SceneCopy.of(uri))
        until("it has begun") { !library.copies.list().isNullOrEmpty() }
        press(notice, R.id.notice_no)
        assertNull(SceneCopy.of(uri))
        assertFalse(notice.isShown)
        fill(File(material, "pipe"), ByteArray(100)) // so that its thread ends
        until("nothing is left") { library.copies.list()!!.isEmpty() }
    }

    @Test
    fun partsOfAnEarlierProcessAreRemoved() {
        library.copies.mkdirs()
        val part = File(library.copies, "old.glb.part").apply { writeText("half") }
        openList()
        until("it is gone") { !part.exists() }
    }

    @Test
    fun twoScenesOfOneNameAreBothKept() {
        val uri = Documents.offer(File(material, "scene.glb"))
        val other = Documents.offer(File(material, "scene.splat"))
        val ends = listOf(copy(uri, "a/../b: c.glb"), copy(other, "a/../b: c.glb")).map { it as SceneCopy.Kept }
        assertEquals(2, ends.map { it.uri }.toSet().size)
        for (end in ends) assertTrue(library.owns(end.uri))
    }

    // The list

    @Test
    fun aKeptSceneIsRenamedSharedAndDeleted() {
        val source = openAndKeep()
        settle()
        close()
        openList()
        assertEquals("My garden", name(1))
        choose(1, R.id.rename)
        val dialog = ShadowAlertDialog.getLatestAlertDialog()
        dialog.findViewById<EditText>(R.id.name).setText("Summer: 2026")
        answer(dialog)
        assertEquals("Summer: 2026", name(1))
        choose(1, R.id.details)
        val details = ShadowAlertDialog.getLatestAlertDialog().findViewById<TextView>(android.R.id.message).text
        assertTrue(details.toString(), "28,842 splats" in details)
        choose(1, R.id.share)
        settle()
        @Suppress("DEPRECATION")
        val send = shadowOf(scenes).nextStartedActivity.getParcelableExtra<Intent>(Intent.EXTRA_INTENT)!!
        @Suppress("DEPRECATION")
        val shared = send.getParcelableExtra<Uri>(Intent.EXTRA_STREAM)!!
        context.contentResolver.query(shared, null, null, null, null)!!.use {
            it.moveToFirst()
            assertEquals("Summer- 2026.glb", it.getString(0))
        }
        val bytes = context.contentResolver.openInputStream(shared)!!.use { it.readBytes() }
        assertTrue(bytes.contentEquals(File(material, "scene.glb").readBytes()))
        val kept = Recents(context).find(source)!!
        choose(1, R.id.delete)
        assertTrue("it is asked first", File(kept.uri.path!!).exists())
        answer()
        assertFalse(File(kept.uri.path!!).exists())
        assertEquals(1, grid.adapter.count)
    }

    @Test
    fun aSceneOfAnotherAppIsRemovedFromTheListOnly() {
        val uri = Documents.offer(File(material, "scene.glb"))
        Recents(context).remember(uri, "old.spz", 1_500_000, 123_456, null, null)
        openList()
        assertEquals(
            listOf(R.id.keep_copy, R.id.rename, R.id.share, R.id.details, R.id.forget), offered(1),
        )
        grid.onItemLongClickListener!!.onItemLongClick(grid, grid.getChildAt(1), 1, 1)
        assertTrue("by a long press, too", ShadowPopupMenu.getLatestPopupMenu().menu.findItem(R.id.forget).isVisible)
        choose(1, R.id.forget)
        answer()
        assertEquals(1, grid.adapter.count)
        assertNull(Recents(context).find(uri))
        assertEquals("the sample stays", listOf(R.id.share, R.id.details), offered(0))
    }

    @Test
    fun aSceneIsKeptFromTheList() {
        val uri = Documents.offer(File(material, "scene.glb"))
        Recents(context).remember(uri, "old.glb", 1_500_000, 123_456, null, null)
        openList()
        choose(1, R.id.keep_copy)
        until("it is kept") { SceneCopy.of(uri) == null }
        settle()
        assertTrue(R.id.delete in offered(1))
        Documents.answers.clear()
        openAndDraw(Recents(context).find(uri)!!.uri)
    }

    @Test
    fun aSceneThatNobodyGivesAnyMoreIsNotKept() {
        val uri = Documents.uri("gone.glb")
        Recents(context).remember(uri, "gone.glb", 1_500_000, 123_456, null, null)
        openList()
        choose(1, R.id.keep_copy)
        until("that is said") { ShadowToast.getTextOfLatestToast() == context.getString(R.string.copy_gone) }
        assertNotNull(Recents(context).find(uri))
    }

    @Test
    fun whatTheAppKeepsIsListedWhateverHappensToTheList() {
        openAndKeep()
        settle()
        close()
        File(context.filesDir, "recents/list.json").writeText("broken")
        openList()
        assertEquals(2, grid.adapter.count)
        assertEquals("My garden", name(1))
        for (i in 0..Recents.MOST) Recents(context).remember(Documents.uri("$i"), "$i", 1, 1, null, null)
        assertTrue(library.files().isNotEmpty())
    }

    @Test
    fun keptScenesAreNotPushedOffTheList() {
        val uri = openAndKeep()
        settle()
        for (i in 0..Recents.MOST) Recents(context).remember(Documents.uri("$i"), "$i", 1, 1, null, null)
        assertNotNull(Recents(context).find(uri))
        assertEquals(Recents.MOST + 1, Recents(context).all().size)
    }

    @Test
    fun aSceneThatIsDeletedUnderTheViewerIsShownStillAndThenGone() {
        val uri = openAndKeep()
        settle()
        val kept = Recents(context).find(uri)!!
        val before = settled()
        assertTrue(library.delete(kept.uri))
        Recents(context).forget(kept.uri)
        assertTrue(psnr(before, settled()) > 45)
        controller!!.pause()
        settle()
        assertTrue("it does not come back into the list", Recents(context).all().isEmpty())
        close()
        assertEquals(context.getString(R.string.moved_or_deleted), openAndFail(kept.uri))
    }

    @Test
    fun othersAreGivenWhatLiesInTheLibraryOnly() {
        File(context.filesDir, "secret.glb").writeText("secret")
        library.newFile("kept.glb").writeText("kept")
        val base = "content://${context.packageName}.shared"
        for (bad in listOf("$base/library/..%2Fsecret.glb", "$base/recents/list.json", "$base/library", "$base"))
            assertTrue(bad, runCatching { context.contentResolver.openInputStream(Uri.parse(bad)) }.isFailure)
        context.contentResolver.openInputStream(Uri.parse("$base/library/kept.glb"))!!.use {
            assertEquals("kept", it.reader().readText())
        }
    }
}
