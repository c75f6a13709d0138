package org.fluxgs.app

import android.app.AlertDialog
import android.content.Intent
import android.net.Uri
import android.view.View
import android.widget.EditText
import com.sun.net.httpserver.HttpExchange
import com.sun.net.httpserver.HttpServer
import java.io.File
import java.io.IOException
import java.net.HttpURLConnection
import java.net.InetSocketAddress
import java.net.SocketTimeoutException
import java.net.URL
import java.net.UnknownHostException
import java.nio.file.Files
import java.util.concurrent.CountDownLatch
import java.util.concurrent.Executors
import java.util.concurrent.atomic.AtomicInteger
import javax.net.ssl.SSLException
import org.junit.After
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
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
import org.robolectric.shadows.ShadowAlertDialog
import org.robolectric.shadows.ShadowPopupMenu

/** The app that opens links, with a server of this machine: what is asked of https://example.org goes there. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w411dp-h731dp-port-hdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class LinkTest {
    private val context = RuntimeEnvironment.getApplication()
    private val library = Library(context)
    private var controller: ActivityController<LinkActivity>? = null
    private val activity get() = controller!!.get()
    private val asked = AtomicInteger()
    private val scene = File(material, "scene.spz").readBytes()
    private val threads = Executors.newCachedThreadPool { Thread(it).apply { isDaemon = true } }
    private val server = HttpServer.create(InetSocketAddress("127.0.0.1", 0), 0).apply {
        executor = threads
        start()
    }

    @Before
    fun askThisMachine() {
        library.copies.mkdirs()
        Link.connections = { url ->
            asked.incrementAndGet()
            URL("http", "127.0.0.1", server.address.port, url.file).openConnection() as HttpURLConnection
        }
        serve("/scene.spz") { it.send(scene) }
    }

    private fun leave() {
        controller?.end()
        controller = null
    }

    @After
    fun close() {
        leave()
        server.stop(0)
        threads.shutdownNow()
    }

    private fun serve(path: String, answer: (HttpExchange) -> Unit) {
        server.createContext(path) {
            try {
                it.use(answer)
            } catch (_: IOException) {
                // nobody reads on
            }
        }
    }

    private fun HttpExchange.use(answer: (HttpExchange) -> Unit) = try {
        answer(this)
    } finally {
        close()
    }

    private fun HttpExchange.send(bytes: ByteArray, code: Int = 200, type: String = "application/octet-stream") {
        responseHeaders.add("Content-Type", type)
        sendResponseHeaders(code, bytes.size.toLong())
        responseBody.write(bytes)
    }

    private fun HttpExchange.redirect(to: String) {
        responseHeaders.add("Location", to)
        sendResponseHeaders(302, -1)
    }

    private fun intent(link: String) =
        Intent(Intent.ACTION_VIEW, Uri.parse(link), context, LinkActivity::class.java)

    private fun shared(text: String?) =
        Intent(context, LinkActivity::class.java).setAction(Intent.ACTION_SEND).putExtra(Intent.EXTRA_TEXT, text)

    private fun start(intent: Intent) {
        controller = Robolectric.buildActivity(LinkActivity::class.java, intent).setup()
        pump()
    }

    private fun open(path: String) = start(intent("https://example.org$path"))

    private fun opened(): File {
        until("the scene is opened") { activity.isFinishing }
        val next = shadowOf(activity).nextStartedActivity
        assertEquals(ViewerActivity::class.java.name, next.component!!.className)
        return File(next.data!!.path!!)
    }

    private fun failed(): String {
        until("it is said") { activity.isShown(R.id.loading_leave) }
        until("nothing is left of it") { library.copies.list()!!.isEmpty() }
        assertTrue("nor in the list", Recents(context).all().isEmpty())
        return activity.text(R.id.loading_detail)
    }

    private fun failed(path: String): String {
        open(path)
        return failed().also { leave() }
    }

    private fun press(id: Int) {
        activity.view(id).performClick()
        pump()
    }

    private fun text(id: Int, vararg values: Any) = context.getString(id, *values)

    @Test
    fun aSceneIsDownloadedKeptAndOpened() {
        open("/scene.spz")
        val file = opened()
        assertEquals(File(library.copies, "scene.spz"), file)
        assertTrue(file.readBytes().contentEquals(scene))
        assertEquals(Uri.parse("https://example.org/scene.spz"), Recents(context).all().single().source)
    }

    @Test
    fun redirectsAreFollowedOverHttpsOnlyAndNotForEver() {
        serve("/moved") { it.redirect("https://example.org/moved-again") }
        serve("/moved-again") { it.redirect("/scene.spz") }
        open("/moved/garden.spz")
        assertEquals("called as the link", "garden.spz", opened().name)
        leave()
        File(library.copies, "garden.spz").delete()
        Recents(context).all().forEach { Recents(context).forget(it.uri) }
        serve("/open") { it.redirect("http://example.org/scene.spz") }
        serve("/round") { it.redirect("/round") }
        serve("/nowhere") { it.redirect("file:///data/secret.glb") }
        assertEquals(text(R.string.link_insecure), failed("/open"))
        assertEquals(text(R.string.link_redirects), failed("/round"))
        assertEquals(text(R.string.link_broken), failed("/nowhere"))
    }

    @Test
    fun whatIsNoFileIsSaidInWords() {
        for ((code, words) in listOf(
            404 to R.string.link_gone, 410 to R.string.link_gone, 403 to R.string.link_forbidden,
            500 to R.string.link_refused, 503 to R.string.link_refused, 206 to R.string.link_refused,
        )) {
            serve("/code-$code") { it.send(scene, code) }
            assertEquals(text(words, code), failed("/code-$code"))
        }
        serve("/page.glb") { it.send("hello".toByteArray(), type = "text/html; charset=utf-8") }
        serve("/hidden.glb") { it.send("\n \uFEFF<!DOCTYPE html><html>".toByteArray()) }
        serve("/letter") { it.send("hello".toByteArray()) }
        assertEquals("That link leads to a web page, not to a scene file.", failed("/page.glb"))
        assertEquals(text(R.string.link_to_page), failed("/hidden.glb"))
        assertEquals(text(R.string.scene_broken), failed("/letter"))
        serve("/nothing") { it.sendResponseHeaders(200, -1) }
        assertEquals(text(R.string.scene_broken), failed("/nothing"))
    }

    @Test
    fun whatIsCutOrTooLargeIsNotKept() {
        serve("/cut.spz") {
            it.sendResponseHeaders(200, scene.size.toLong())
            it.responseBody.write(scene, 0, scene.size / 2)
            it.responseBody.flush()
            server.stop(0) // and with it the connection
        }
        serve("/large.spz") {
            it.sendResponseHeaders(200, Link.MOST_BYTES + 1)
            it.responseBody.write(scene)
        }
        assertEquals(text(R.string.link_too_large, Texts.size(context, Link.MOST_BYTES)), failed("/large.spz"))
        assertEquals(text(R.string.link_cut), failed("/cut.spz"))
    }

    private fun copy(link: Link): SceneCopy.End {
        var end: SceneCopy.End? = null
        SceneCopy.start(context, link).onEnd { end = it }
        until("it has ended") { end != null }
        return end!!
    }

    @Test
    fun aFileThatNeverEndsIsStopped() {
        serve("/endless.splat") {
            it.sendResponseHeaders(200, 0) // in chunks
            // A stream that is closed is read on while there is something: here to its end, by Android for 0.1 s
            repeat(400) { _ ->
                it.responseBody.write(scene)
                Thread.sleep(5)
            }
        }
        val end = copy(Link(context, Uri.parse("https://example.org/endless.splat"), 5_000_000)) as SceneCopy.Failed
        assertEquals(text(R.string.link_too_large, Texts.size(context, 5_000_000)), end.message)
        until("nothing is left") { library.copies.list()!!.isEmpty() }
    }

    @Test
    fun storageThatIsFullIsSaidToBe() {
        Files.createSymbolicLink(File(library.copies, "scene.spz.part").toPath(), File("/dev/full").toPath())
        val said = failed("/scene.spz")
        assertTrue(said, Texts.size(context, scene.size.toLong()) in said)
        serve("/much.spz") { it.sendResponseHeaders(200, Link.MOST_BYTES) }
        if (library.copies.usableSpace < Link.MOST_BYTES) failed("/much.spz")
    }

    @Test
    fun aServerThatIsNotThereIsSaidToBe() {
        for ((problem, words) in listOf(
            UnknownHostException("x") to text(R.string.link_no_server, "example.org"),
            SSLException("x") to text(R.string.link_not_secure, "example.org"),
            SocketTimeoutException("x") to text(R.string.link_stalled), IOException("x") to text(R.string.link_cut),
        )) {
            Link.connections = { throw problem }
            assertEquals(words, failed("/scene.spz"))
        }
    }

    @Test
    fun progressIsShownAndCancelLeavesNothing() {
        val gate = CountDownLatch(1)
        serve("/slow.spz") {
            it.sendResponseHeaders(200, scene.size.toLong())
            it.responseBody.write(scene, 0, scene.size / 2)
            it.responseBody.flush()
            gate.await()
        }
        open("/slow.spz")
        until("some of it came") { " of " in activity.text(R.id.loading_detail) }
        val size = Texts.size(context, scene.size.toLong())
        until("of how much is said") { " of $size" in activity.text(R.id.loading_detail) }
        assertTrue("and from where", activity.text(R.id.loading_detail).endsWith("from example.org"))
        assertTrue(activity.view(R.id.loading).keepScreenOn)
        keep(screenOf(activity, null), "downloading")
        press(R.id.loading_cancel)
        assertTrue(activity.isFinishing)
        gate.countDown() // a connection of this machine, other than Android's, does not end a read
        until("nothing is left") { library.copies.list()!!.isEmpty() }
        assertTrue(Recents(context).all().isEmpty())
    }

    @Test
    fun anInsecureLinkIsNotFollowed() {
        start(shared("Look: http://example.org/scene.spz"))
        assertEquals(text(R.string.link_insecure), failed())
        assertEquals("nobody is asked", 0, asked.get())
    }

    @Test
    fun aTextThatIsSharedMayHaveALinkInIt() {
        start(shared("My garden (https://example.org/scene.spz), have a look!"))
        assertTrue(opened().readBytes().contentEquals(scene))
        leave()
        for (text in listOf("no link here", "", null)) {
            start(shared(text))
            until("it is said") { activity.isShown(R.id.loading_leave) }
            assertEquals(text(R.string.nothing_shared), activity.text(R.id.loading_detail))
            leave()
        }
    }

    @Test
    fun twoLinksQuicklyAfterOneAnotherBothCome() {
        val gate = CountDownLatch(1)
        serve("/first.spz") {
            gate.await()
            it.send(scene)
        }
        open("/first.spz")
        controller!!.newIntent(intent("https://example.org/scene.spz"))
        gate.countDown()
        until("both are there") { activity.isFinishing }
        assertEquals(listOf("first.spz", "scene.spz"), library.copies.list()!!.sorted())
        assertEquals(ScenesActivity::class.java.name, shadowOf(activity).nextStartedActivity.component!!.className)
    }

    @Test
    fun whatIsThereAlreadyIsNotDownloadedAgain() {
        open("/scene.spz")
        val file = opened()
        leave()
        val before = asked.get()
        open("/scene.spz")
        assertEquals(file, opened())
        assertEquals(before, asked.get())
        leave()
        file.delete()
        open("/scene.spz")
        assertTrue("one that was deleted is", opened().exists() && asked.get() > before)
    }

    @Test
    fun anotherTryMayHelp() {
        val ready = AtomicInteger()
        serve("/later.spz") { if (ready.get() == 0) it.send(ByteArray(1), 503) else it.send(scene) }
        open("/later.spz")
        failed()
        ready.set(1)
        press(R.id.loading_retry)
        assertTrue(opened().exists())
    }

    /** Nothing is opened over another app; what has come is opened when people are back. */
    @Test
    fun whatComesWhileNobodyLooksIsOpenedLater() {
        val gate = CountDownLatch(1)
        serve("/slow.spz") {
            gate.await()
            it.send(scene)
        }
        open("/slow.spz")
        controller!!.pause().stop()
        gate.countDown()
        until("it is there") { library.copies.list()!!.contentEquals(arrayOf("slow.spz")) }
        repeat(5) { pump() }
        assertFalse(activity.isFinishing)
        controller!!.start().resume()
        assertTrue(opened().exists())
    }

    @Test
    fun aLinkIsTypedFromTheMenuOfTheList() {
        val list = Robolectric.buildActivity(ScenesActivity::class.java).setup()
        list.get().findViewById<View>(R.id.more).performClick()
        val menu = ShadowPopupMenu.getLatestPopupMenu().menu
        val entry = (0 until menu.size()).map { menu.getItem(it) }.first()
        assertEquals("Open link", entry.title)
        menu.performIdentifierAction(entry.itemId, 0)
        val next = shadowOf(list.get()).nextStartedActivity
        assertEquals(LinkActivity::class.java.name, next.component!!.className)
        list.end()
        start(next)
        type("example.org/scene.spz")
        assertEquals(text(R.string.link_broken), field.error.toString())
        type("https://example.org/scene.spz")
        assertTrue(opened().exists())
    }

    private val dialog get() = ShadowAlertDialog.getLatestAlertDialog()
    private val field get() = dialog.findViewById<EditText>(R.id.name)

    private fun type(link: String) {
        field.setText(link)
        dialog.getButton(AlertDialog.BUTTON_POSITIVE).performClick()
        pump()
    }

    @Test
    fun linksToScenesAreOfferedToTheApp() {
        fun takers(link: String) = context.packageManager
            .queryIntentActivities(Intent(Intent.ACTION_VIEW, Uri.parse(link)), 0).map { it.activityInfo.name }
        for (name in listOf("a.glb", "b/c.d.spz", "x.sog", "x.ply", "x.splat?download=1"))
            assertEquals(name, listOf(LinkActivity::class.java.name), takers("https://example.org/$name"))
        for (link in listOf("https://example.org/index.html", "https://example.org/", "http://example.org/a.glb"))
            assertEquals(link, emptyList<String>(), takers(link))
    }
}
