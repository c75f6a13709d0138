package org.fluxgs.app

import android.app.Activity
import android.content.ComponentCallbacks2
import android.content.Intent
import android.graphics.Bitmap
import android.net.Uri
import android.os.Bundle
import android.os.ParcelFileDescriptor
import android.os.SystemClock
import android.view.MotionEvent
import android.view.View
import android.view.ViewGroup
import java.io.File
import org.junit.After
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNotNull
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
import org.robolectric.shadows.ShadowDialog
import org.robolectric.shadows.ShadowToast

private const val WIDTH = 640
private const val HEIGHT = 480

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [35], qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class ViewerTest {
    private val context = RuntimeEnvironment.getApplication()
    private var controller: ActivityController<ViewerActivity>? = null
    private val activity get() = controller!!.get()
    private val session get() = activity.view(R.id.surface).let { (it as SceneSurface).session!! }

    @Before
    fun sharp() {
        pauseDisplay()
        Documents.install()
        Settings(scale = 1f, sorter = 2).save(context)
    }

    @After
    fun close() {
        controller?.end()
        controller = null
    }

    private fun start(intent: Intent, state: Bundle? = null) {
        controller = Robolectric.buildActivity(ViewerActivity::class.java, intent)
        if (state == null) controller!!.create() else controller!!.create(state)
        controller!!.start().resume().visible()
        giveSurface(activity.view(R.id.surface) as SceneSurface, WIDTH, HEIGHT)
        pump()
    }

    private fun open(uri: Uri?) =
        start(Intent(context, ViewerActivity::class.java).setData(uri))

    private fun openAndDraw(uri: Uri? = null) {
        open(uri)
        until("the scene is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
    }

    private fun openAndFail(uri: Uri): String {
        open(uri)
        until("the app says that it cannot") { activity.isShown(R.id.loading_retry) }
        return activity.text(R.id.loading_detail)
    }

    /** When the picture does not change any more. */
    private fun settled(): Bitmap {
        var last = session.picture()!!
        until("the picture is still") {
            repeat(5) { pump() }
            val now = session.picture()!!
            val still = now.sameAs(last)
            last = now
            still
        }
        return last
    }

    private var touched = 0L

    /** `at`: ms after the first finger came down. */
    private fun touch(action: Int, at: Long, vararg points: Pair<Float, Float>) {
        if (action == MotionEvent.ACTION_DOWN) touched = SystemClock.uptimeMillis()
        val properties = Array(points.size) { index ->
            MotionEvent.PointerProperties().apply { id = index }
        }
        val places = Array(points.size) { index ->
            MotionEvent.PointerCoords().apply {
                x = points[index].first
                y = points[index].second
                pressure = 1f
            }
        }
        val event = MotionEvent.obtain(
            touched, touched + at, action, points.size, properties, places, 0, 0, 1f, 1f, 0, 0, 0,
            0,
        )
        activity.view(R.id.surface).dispatchTouchEvent(event)
        event.recycle()
        pump()
    }

    private fun drag(from: Pair<Float, Float>, to: Pair<Float, Float>) {
        touch(MotionEvent.ACTION_DOWN, 0, from)
        for (i in 1..10) touch(
            MotionEvent.ACTION_MOVE, 30L * i,
            from.first + (to.first - from.first) * i / 10 to
                from.second + (to.second - from.second) * i / 10,
        )
        touch(MotionEvent.ACTION_MOVE, 900, to) // it rests: no fling
        touch(MotionEvent.ACTION_UP, 1000, to)
    }

    private fun press(id: Int) {
        activity.view(id).performClick()
        pump()
    }

    // Opening

    @Test
    fun theSampleIsDrawnAsTheDesktopDrawsIt() {
        openAndDraw()
        val picture = settled()
        keep(picture, "sample-scene")
        val found = psnr(picture, pictureOf("sample.png"))
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
        open(Documents.uri("garden.ply"))
        until("it is read") { session.state()!!.loading.phase == "reading" }
        val part = File(material, "scene.ply").inputStream().use { it.readNBytes(1_000_000) }
        java.io.FileOutputStream(File(material, "pipe")).use { it.write(part) }
        until("what it will take is said") { "28,842 splats" in activity.text(R.id.loading_detail) }
        assertTrue(activity.isShown(R.id.loading_cancel))
        keep(screenOf(activity, null), "loading")
        press(R.id.loading_cancel)
        assertTrue(activity.isFinishing)
    }

    @Test
    fun aProviderThatNeverAnswersIsGivenUp() {
        val gate = java.util.concurrent.CountDownLatch(1)
        Documents.answers["stuck"] = {
            gate.await()
            throw IllegalStateException("late")
        }
        open(Documents.uri("stuck"))
        pump(SceneOpening.PATIENCE_MS + 1000)
        assertTrue(activity.isShown(R.id.loading_retry))
        assertEquals(context.getString(R.string.provider_stalls), activity.text(R.id.loading_detail))
        gate.countDown()
        repeat(5) { pump() }
        assertTrue("a late answer changes nothing", activity.isShown(R.id.loading_retry))
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
            close()
        }
    }

    @Test
    fun everyButtonCanBeReachedInANarrowWindow() {
        openAndDraw()
        val tools = listOf(
            R.id.back, R.id.reset, R.id.flip, R.id.gyroscope, R.id.screenshot, R.id.measure, R.id.options,
        ).map { activity.view(it) }
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
        activity.view(R.id.measure).performClick()
        assertEquals(Scene.SAMPLE, shadowOf(activity).nextStartedActivity.data)
    }

    @Test
    fun aFileThatIsGone() {
        assertEquals(context.getString(R.string.scene_gone), openAndFail(Documents.uri("nothing")))
        keep(screenOf(activity, null), "cannot-open")
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
        assertTrue(openAndFail(Documents.uri("rude")).contains("broken app"))
    }

    @Test
    fun aFileThatIsNoScene() {
        val file = File(context.cacheDir, "letter.pdf").apply { writeText("%PDF-1.7 hello") }
        val said = openAndFail(Documents.offer(file))
        assertTrue(said, said.contains("no known scene format"))
    }

    @Test
    fun hostileFilesAreTurnedAwayAndTheAppLivesOn() {
        for (name in listOf("cut.glb", "cut.ply", "many.ply", "zeros.spz", "empty.glb")) {
            val said = openAndFail(Documents.offer(File(material, name)))
            assertTrue("$name: $said", said.length in 10..400)
            close()
        }
        openAndDraw()
    }

    @Test
    fun aFileLargerThanTheMemoryIsSaidToBe() {
        val file = File(context.cacheDir, "large.ply")
        java.io.RandomAccessFile(file, "rw").use {
            it.write("ply\nformat binary_little_endian 1.0\nelement vertex 9000000\n".toByteArray())
            it.setLength(2L shl 30)
        }
        memory(600L shl 20)
        val said = openAndFail(Documents.offer(file))
        assertTrue(said, said.contains("memory") || said.contains("MB"))
        file.delete()
    }

    private fun memory(bytes: Long) {
        val info = android.app.ActivityManager.MemoryInfo().apply {
            availMem = bytes
            totalMem = 4L shl 30
            threshold = 0
        }
        shadowOf(context.getSystemService(android.app.ActivityManager::class.java)).setMemoryInfo(info)
    }

    @Test
    fun aFileThatWasMendedCanBeTriedAgain() {
        val file = File(context.cacheDir, "mended.glb").apply { writeText("nothing") }
        openAndFail(Documents.offer(file))
        File(material, "scene.glb").copyTo(file, true)
        press(R.id.loading_retry)
        until("the scene is drawn") { session.state()!!.drawn }
    }

    // Moving

    @Test
    fun oneFingerTurnsTheSceneAndResetBringsItBack() {
        openAndDraw()
        val before = settled()
        drag(320f to 240f, 420f to 250f)
        val turned = settled()
        assertTrue(psnr(before, turned) < 25)
        keep(screenOf(activity, turned), "viewer")
        press(R.id.reset)
        assertTrue(psnr(before, settled()) > 45)
    }

    @Test
    fun twoFingersComeNearer() {
        openAndDraw()
        val before = session.place()!!
        touch(MotionEvent.ACTION_DOWN, 0, 300f to 240f)
        touch(
            MotionEvent.ACTION_POINTER_DOWN or (1 shl MotionEvent.ACTION_POINTER_INDEX_SHIFT), 10,
            300f to 240f, 340f to 240f,
        )
        for (i in 1..10) touch(
            MotionEvent.ACTION_MOVE, 30L * i, 300f - 8 * i to 240f, 340f + 8 * i to 240f,
        )
        touch(
            MotionEvent.ACTION_POINTER_UP or (1 shl MotionEvent.ACTION_POINTER_INDEX_SHIFT), 400,
            220f to 240f, 420f to 240f,
        )
        touch(MotionEvent.ACTION_UP, 410, 220f to 240f)
        settled()
        val after = session.place()!!
        assertTrue("nearer", after.indices.any { kotlin.math.abs(after[it] - before[it]) > 1e-3 })
        assertTrue(spread(session.picture()!!) > 100)
    }

    @Test
    fun flipTurnsThePictureUpsideDown() {
        openAndDraw()
        val before = settled()
        press(R.id.flip)
        assertTrue(psnr(before, settled()) < 25)
        press(R.id.flip)
        assertTrue(psnr(before, settled()) > 45)
    }

    @Test
    fun aTapHidesTheControlsAndAnotherShowsThem() {
        openAndDraw()
        repeat(2) { round ->
            touch(MotionEvent.ACTION_DOWN, 0, 100f to 300f)
            touch(MotionEvent.ACTION_UP, 50, 100f to 300f)
            pump(1000)
            assertEquals(round == 1, activity.isShown(R.id.controls))
        }
    }

    @Test
    fun buttonsHaveNamesForTalkBack() {
        openAndDraw()
        for (id in intArrayOf(
            R.id.back, R.id.reset, R.id.flip, R.id.screenshot, R.id.measure, R.id.options,
            R.id.surface,
        )) assertFalse(activity.view(id).contentDescription.isNullOrEmpty())
    }

    @Test
    fun talkBackMovesTheSceneByNamedActions() {
        openAndDraw()
        val surface = activity.view(R.id.surface)
        val node = surface.createAccessibilityNodeInfo()
        val labels = node.actionList.associate { it.id to it.label?.toString() }
        assertEquals(
            context.getString(R.string.toggle_controls),
            labels[android.view.accessibility.AccessibilityNodeInfo.ACTION_CLICK],
        )
        val start = settled()
        val opposites = listOf(
            R.id.look_left to R.id.look_right, R.id.look_higher to R.id.look_lower,
            R.id.come_nearer to R.id.go_away,
        )
        for ((there, back) in opposites) {
            assertNotNull(labels[there])
            assertNotNull(labels[back])
            surface.performAccessibilityAction(there, null)
            assertTrue("it moves", psnr(start, settled()) < 30)
            surface.performAccessibilityAction(back, null)
            assertTrue("and back", psnr(start, settled()) > 35)
        }
        surface.performAccessibilityAction(
            android.view.accessibility.AccessibilityNodeInfo.ACTION_CLICK, null,
        )
        assertFalse(activity.isShown(R.id.controls))
    }

    @Test
    fun aSceneThatHasNoRoomBesideTheFirstIsOpenedWhenTriedAgain() {
        openAndDraw()
        memory(500L shl 20)
        val file = File(context.cacheDir, "broken.glb").apply { writeText("nothing") }
        controller!!.newIntent(
            Intent(context, ViewerActivity::class.java).setData(Documents.offer(file)),
        )
        until("the app says that it cannot") { activity.isShown(R.id.loading_retry) }
        assertTrue("the first is still there", session.state()!!.hasScene)
        press(R.id.loading_retry)
        until("the app says that it cannot") { activity.isShown(R.id.loading_retry) }
        assertFalse("the first has made room", session.state()!!.hasScene)
    }

    // Settings

    @Test
    fun settingsAreSeenAtOnceAndKept() {
        openAndDraw()
        val before = settled()
        press(R.id.options)
        val dialog = ShadowDialog.getLatestDialog()
        keepDialog(dialog.window!!.decorView)
        dialog.findViewById<android.widget.Spinner>(R.id.degree).setSelection(0)
        pump()
        assertTrue("fewer harmonics", psnr(before, settled()) < 45)
        dialog.findViewById<android.widget.Spinner>(R.id.budget).setSelection(4)
        dialog.findViewById<android.widget.Switch>(R.id.hud).isChecked = false
        pump(300)
        assertFalse(activity.isShown(R.id.hud))
        dialog.dismiss()
        assertEquals(Settings(1f, 2, 0, 100_000, false), Settings.load(context))
        close()
        openAndDraw()
        pump(300)
        assertFalse(activity.isShown(R.id.hud))
    }

    private fun keepDialog(decor: View) {
        decor.measure(
            View.MeasureSpec.makeMeasureSpec(420, View.MeasureSpec.AT_MOST),
            View.MeasureSpec.makeMeasureSpec(900, View.MeasureSpec.AT_MOST),
        )
        decor.layout(0, 0, decor.measuredWidth, decor.measuredHeight)
        val picture = Bitmap.createBitmap(decor.width, decor.height, Bitmap.Config.ARGB_8888)
        decor.draw(android.graphics.Canvas(picture))
        keep(picture, "settings")
    }

    @Test
    fun theNumbersSayWhatIsDrawn() {
        openAndDraw()
        pump(300)
        val hud = activity.text(R.id.hud)
        assertTrue(hud, hud.contains("28.8k of 28.8k") || hud.contains("splats"))
        assertTrue(hud, hud.contains("ms"))
    }

    @Test
    fun aScreenshotGoesToTheGallery() {
        openAndDraw()
        settled()
        press(R.id.screenshot)
        val saved = context.getString(R.string.screenshot_saved)
        until("it is saved") { ShadowToast.getTextOfLatestToast() == saved }
    }

    @Test
    fun measuringStartsTheBenchmarkOfThisSceneAndLeavesItTheMemory() {
        val uri = Documents.offer(File(material, "scene.glb"))
        openAndDraw(uri)
        drag(320f to 240f, 400f to 260f)
        val before = settled()
        press(R.id.measure)
        val next = shadowOf(activity).nextStartedActivity
        assertEquals(BenchmarkActivity::class.java.name, next.component!!.className)
        assertEquals(uri, next.data)
        controller!!.pause().stop()
        assertFalse(session.state()!!.hasScene)
        controller!!.restart().start().resume()
        until("the scene is there again") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        assertTrue("from the same place", psnr(before, settled()) > 45)
    }

    // Life

    @Test
    fun aSceneThatWasLookedAtIsRememberedWithItsPicture() {
        openAndDraw()
        drag(320f to 240f, 380f to 240f)
        settled()
        val place = session.place()!!
        controller!!.pause()
        Background.start {}.get()
        val recent = Recents(context).find(Scene.SAMPLE)!!
        assertEquals(28842L, recent.splats)
        assertNotNull(Recents(context).picture(recent))
        for (i in place.indices) assertEquals(place[i], recent.place!![i], 1e-9)
        controller!!.resume()
    }

    @Test
    fun theViewSurvivesTheEndOfTheProcess() {
        openAndDraw()
        drag(320f to 240f, 400f to 260f)
        val before = settled()
        val state = Bundle()
        controller!!.pause().stop().saveInstanceState(state).destroy()
        controller = null
        start(Intent(context, ViewerActivity::class.java).setData(null), state)
        until("the scene is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        assertTrue(psnr(before, settled()) > 45)
    }

    @Test
    fun rotationKeepsSessionAndScene() {
        openAndDraw()
        val before = session
        RuntimeEnvironment.setQualifiers("w480dp-h640dp-port-mdpi")
        controller!!.configurationChange()
        val surface = activity.view(R.id.surface) as SceneSurface
        surface.surfaceChanged(holder, 0, HEIGHT, WIDTH)
        until("the picture has the other shape") {
            pump()
            session.picture()?.let { it.width == HEIGHT && it.height == WIDTH } == true
        }
        assertTrue(before === session)
        assertEquals(1, session.state()!!.contexts)
        keep(screenOf(activity, settled()), "viewer-portrait")
    }

    @Test
    fun theSurfaceMayComeAndGo() {
        openAndDraw()
        val before = settled()
        val surface = activity.view(R.id.surface) as SceneSurface
        controller!!.pause().stop()
        surface.surfaceDestroyed(holder)
        repeat(3) { pump() }
        controller!!.restart().start().resume()
        giveSurface(surface, WIDTH, HEIGHT)
        assertTrue(psnr(before, settled()) > 45)
    }

    @Test
    fun aLostContextIsMadeAnew() {
        openAndDraw()
        val before = settled()
        session.loseContext()
        until("there is another context") { session.state()!!.contexts == 2 }
        until("the scene is drawn") { session.state()!!.drawn }
        assertTrue(psnr(before, settled()) > 45)
    }

    @Test
    fun littleMemoryLeavesOutSplatsAndNotTheApp() {
        memory(500L shl 20)
        openAndDraw()
        controller!!.get().onTrimMemory(ComponentCallbacks2.TRIM_MEMORY_COMPLETE)
        repeat(10) { pump() }
        assertTrue(session.state()!!.hasScene)
        assertTrue(spread(settled()) > 100)
    }

    @Test
    fun aSessionThatIsGoneDoesNothing() {
        openAndDraw()
        val gone = session
        close()
        gone.frame(1)
        gone.resetView()
        assertEquals(null, gone.state())
        assertEquals(null, gone.picture())
    }
}
