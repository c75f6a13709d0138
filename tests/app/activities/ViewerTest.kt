package org.fluxgs.app

import android.content.Intent
import android.hardware.Sensor
import android.hardware.SensorManager
import android.graphics.Bitmap
import android.graphics.BitmapFactory
import android.net.Uri
import android.os.Build
import android.os.Bundle
import android.os.ParcelFileDescriptor
import android.os.SystemClock
import android.view.MotionEvent
import android.view.View
import java.io.File
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNotNull
import org.junit.Assert.assertNull
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.SensorEventBuilder
import org.robolectric.shadows.ShadowDialog
import org.robolectric.shadows.ShadowSensor
import org.robolectric.shadows.ShadowToast

@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class ViewerTest : ViewerScreen() {
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
    fun aResetCanBeUndoneForAWhile() {
        openAndDraw()
        drag(320f to 240f, 420f to 250f)
        val turned = settled()
        press(R.id.reset)
        val undo = activity.view(R.id.undo)
        assertTrue(undo.isShown)
        keep(screenOf(activity, turned), "undo")
        undo.findViewById<View>(R.id.notice_yes).performClick()
        assertFalse(undo.isShown)
        assertTrue("it is where it was", psnr(turned, settled()) > 45)
        press(R.id.reset)
        assertTrue(psnr(turned, settled()) < 25)
        pump(ViewerActivity.UNDO_MS + 100)
        assertFalse(undo.isShown)
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
        val distance = 7 // of a place's numbers
        assertTrue("nearer", after[distance] < 0.8 * before[distance])
        assertTrue(spread(session.image()!!) > 100)
    }

    @Test
    fun flipTurnsTheImageUpsideDown() {
        openAndDraw()
        val before = settled()
        more(R.id.flip)
        assertTrue(psnr(before, settled()) < 25)
        more(R.id.flip)
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
            R.id.back, R.id.reset, R.id.screenshot, R.id.more, R.id.surface,
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

    // Settings

    @Test
    fun qualityIsChosenOverTheSceneAndKept() {
        openAndDraw()
        val before = settled()
        val dialog = openQuality()
        val choices = dialog.findViewById<android.widget.RadioGroup>(R.id.qualities)
        assertEquals("values of somebody's own", -1, choices.checkedRadioButtonId)
        choices.check(R.id.battery)
        assertEquals(Quality.BATTERY, Quality.ofSettings(Settings.load(context)))
        until("the rate is another") { session.state()!!.stats.goal < 31 }
        assertTrue("at rest it has all pixels", psnr(before, settled()) > 35)
        choices.check(R.id.sharp)
        assertEquals(Settings(scale = 1f), Settings.load(context))
        keepSheet(dialog, before)
        dialog.dismiss()
    }

    @Test
    fun whatQualityStandsForCanBeChosenOneByOne() {
        openAndDraw()
        val before = settled()
        val dialog = openQuality()
        val choices = dialog.findViewById<android.widget.RadioGroup>(R.id.qualities)
        choices.check(R.id.automatic)
        val advanced = dialog.findViewById<View>(R.id.advanced_settings)
        assertEquals(View.GONE, advanced.visibility)
        dialog.findViewById<android.widget.CheckBox>(R.id.advanced).isChecked = true
        assertEquals(View.VISIBLE, advanced.visibility)
        dialog.findViewById<android.widget.Spinner>(R.id.degree).setSelection(0)
        pump()
        assertTrue("fewer SH coefficients", psnr(before, settled()) < 45)
        assertEquals("no quality has these values", -1, choices.checkedRadioButtonId)
        dialog.findViewById<android.widget.Spinner>(R.id.budget).setSelection(4)
        pump()
        assertEquals(Settings(shDegree = 0, maxSplats = 100_000), Settings.load(context))
        dialog.dismiss()
    }

    private fun openQuality(): android.app.Dialog {
        more(R.id.quality)
        return ShadowDialog.getLatestDialog()
    }

    @Test
    fun everyQualityStandsForValuesOfItsOwn() {
        val own = Settings(sorter = 2, hud = true)
        for (quality in Quality.entries) {
            assertEquals(quality, Quality.ofSettings(quality.of(own)))
            assertTrue("what has nothing to do with it stays", quality.of(own).hud)
        }
    }

    /** The scene with the sheet over it, as the system puts its window. */
    private fun keepSheet(dialog: android.app.Dialog, scene: Bitmap) {
        val screen = screenOf(activity, scene)
        val attributes = dialog.window!!.attributes
        val decor = dialog.window!!.decorView
        decor.measure(
            View.MeasureSpec.makeMeasureSpec(attributes.width, View.MeasureSpec.EXACTLY),
            View.MeasureSpec.makeMeasureSpec(screen.height, View.MeasureSpec.AT_MOST),
        )
        decor.layout(0, 0, decor.measuredWidth, decor.measuredHeight)
        decor.jumpDrawablesToCurrentState()
        val canvas = android.graphics.Canvas(screen)
        canvas.translate((screen.width - decor.width).toFloat(), (screen.height - decor.height).toFloat())
        decor.draw(canvas)
        keep(screen, "quality")
    }

    @Test
    fun statisticsAreShownToWhoAsks() {
        openAndDraw()
        assertFalse(activity.isShown(R.id.hud))
        more(R.id.statistics)
        until("they are shown") { activity.isShown(R.id.hud) }
        keep(screenOf(activity, settled()), "statistics")
        close()
        openAndDraw()
        until("they are still") { activity.isShown(R.id.hud) }
        more(R.id.statistics)
        until("they are gone") { !activity.isShown(R.id.hud) }
    }

    @Test
    fun whatIsMissingFromTheImageIsSaidToEverybody() {
        val hud = android.widget.TextView(context)
        fun said(stats: Stats, numbers: Boolean = false): String {
            Hud.show(hud, stats, numbers)
            return if (hud.visibility == View.VISIBLE) hud.text.toString() else ""
        }
        val whole = Stats(
            59.7, 60.0, 8.0, 1.0, 28_000, 28_842, 28_842, 1, 1, 640, 480, 0.85, 1L shl 20, false, 1.0, 1.0,
        )
        assertEquals("", said(whole))
        assertEquals("60 fps · 28K of 29K splats · sharpness 85%", said(whole, true))
        assertEquals(context.getString(R.string.reduced_heat), said(whole.copy(coolest = 0.7)))
        assertEquals(context.getString(R.string.reduced_memory), said(whole.copy(reduced = true)))
        assertEquals(2, said(whole.copy(image = 0.5), true).lines().size)
    }

    /** While something moves nobody wants them; who needs to find them by touch does. */
    @Test
    fun theToolsFadeWhileTheSceneMovesAndComeBackAtRest() {
        openAndDraw()
        val tools = activity.view(R.id.back)
        val fade = ToolsFade(tools)
        fun moves(ms: Long, moving: Boolean) = repeat((ms / 200).toInt()) {
            pump(200)
            fade.look(moving)
        }
        moves(ToolsFade.FADE_AFTER_MS - 400, true)
        assertEquals(View.VISIBLE, tools.visibility)
        moves(400, false)
        moves(ToolsFade.FADE_AFTER_MS - 400, true)
        assertEquals("it rested between", View.VISIBLE, tools.visibility)
        moves(2000, true)
        assertEquals(View.INVISIBLE, tools.visibility)
        moves(400, false)
        assertEquals(View.VISIBLE, tools.visibility)
        moves(ToolsFade.FADE_AFTER_MS + 1000, true)
        fade.toggle()
        pump(400)
        assertEquals("a tap brings them", View.VISIBLE, tools.visibility)
        fade.toggle()
        moves(1000, false)
        assertEquals("who does not want them is not shown them", View.GONE, tools.visibility)
        fade.toggle()
        val manager = context.getSystemService(android.view.accessibility.AccessibilityManager::class.java)
        shadowOf(manager).setTouchExplorationEnabled(true)
        moves(ToolsFade.FADE_AFTER_MS + 1000, true)
        assertEquals(View.VISIBLE, tools.visibility)
    }

    @Test
    fun theGesturesAreToldOnce() {
        context.getSharedPreferences("hints", android.content.Context.MODE_PRIVATE).edit().clear().commit()
        openAndDraw()
        until("they are told") { activity.isShown(R.id.hints) }
        if (Build.VERSION.SDK_INT >= 28)
            assertEquals(context.getString(R.string.hint_title), activity.view(R.id.hints).accessibilityPaneTitle)
        keep(screenOf(activity, settled()), "hints")
        press(R.id.hints_done)
        assertFalse(activity.isShown(R.id.hints))
        close()
        openAndDraw()
        pump(300)
        assertFalse(activity.isShown(R.id.hints))
    }

    @Test
    fun theTitleIsTheScenesName() {
        val file = File(material, "scene.glb").copyTo(File(context.cacheDir, "garden.glb"), true)
        openAndDraw(Documents.offer(file))
        assertEquals("My garden", activity.text(R.id.title))
    }

    @Test
    fun theNumbersSayWhatIsDrawn() {
        Settings(scale = 1f, sorter = 2, hud = true).save(context)
        openAndDraw()
        pump(300)
        val hud = activity.text(R.id.hud)
        assertTrue(hud, Regex("\\d+K of 29K splats").containsMatchIn(hud))
        assertTrue(hud, "100%" in hud)
    }

    @Test
    fun aScreenshotGoesToTheGallery() {
        openAndDraw()
        val image = settled()
        press(R.id.screenshot)
        if (Build.VERSION.SDK_INT < 29) return isShared(image)
        val saved = context.getString(R.string.screenshot_saved)
        until("it is saved") { ShadowToast.getTextOfLatestToast() == saved }
    }

    /** Android before 10 would ask for a permission. */
    private fun isShared(image: Bitmap) {
        @Suppress("DEPRECATION")
        val send = started().getParcelableExtra<Intent>(Intent.EXTRA_INTENT)!!
        assertEquals("image/png", send.type)
        @Suppress("DEPRECATION")
        val uri = send.getParcelableExtra<Uri>(Intent.EXTRA_STREAM)!!
        val shared = context.contentResolver.openInputStream(uri)!!.use(BitmapFactory::decodeStream)
        assertTrue(psnr(image, shared) > 60)
    }

    @Test
    fun measuringStartsTheBenchmarkOfThisSceneAndLeavesItTheMemory() {
        val uri = Documents.offer(File(material, "scene.glb"))
        openAndDraw(uri)
        drag(320f to 240f, 400f to 260f)
        val before = settled()
        more(R.id.measure)
        val next = started()
        assertEquals(BenchmarkActivity::class.java.name, next.component!!.className)
        assertEquals(uri, next.data)
        assertFalse("before the benchmark asks how much is free", session.state()!!.hasScene)
        controller!!.pause().stop().restart().start().resume()
        until("the scene is there again") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        assertTrue("from the same place", psnr(before, settled()) > 45)
        controller!!.pause().stop()
        assertTrue("it was looked at only", session.state()!!.hasScene)
    }

    /** The buttons need their own room only. */
    @Test
    fun besideTheButtonsTheSceneIsTouched() {
        openAndDraw()
        val back = activity.view(R.id.back)
        val beside = back.width + 60f to back.height / 2f + 8
        val root = activity.view(R.id.root)
        for ((at, hits) in listOf(beside to true, back.width / 2f to back.height / 2f + 8 to false)) {
            val before = session.place()!!
            val (x, y) = at
            val time = SystemClock.uptimeMillis()
            for ((i, action) in listOf(MotionEvent.ACTION_DOWN, MotionEvent.ACTION_MOVE).withIndex())
                root.dispatchTouchEvent(MotionEvent.obtain(time, time + 50 * i, action, x + 40 * i, y, 0))
            if (hits) until("the scene moves") { !before.contentEquals(session.place()!!) }
            root.dispatchTouchEvent(
                MotionEvent.obtain(time, time + 900, MotionEvent.ACTION_CANCEL, x + 40, y, 0),
            )
            settled()
            assertEquals(hits, !before.contentEquals(session.place()!!))
        }
    }

    // Looking around

    private val sensors get() = context.getSystemService(SensorManager::class.java)

    private var attitude = 0.0 // degrees

    /** The device, held upright, is turned by 3 degrees. */
    private fun turnDevice() {
        attitude += 3
        val half = Math.toRadians(attitude) / 2
        val (sin, cos) = Math.sin(half) to Math.cos(half)
        val values = listOf(cos, sin, sin, cos).map { (it * Math.sqrt(0.5)).toFloat() } // x, y, z, w
        val event = SensorEventBuilder.newBuilder()
            .setSensor(sensors.getDefaultSensor(Sensor.TYPE_GAME_ROTATION_VECTOR))
            .setValues(values.toFloatArray())
            .setTimestamp(SystemClock.elapsedRealtimeNanos())
            .build()
        shadowOf(sensors).sendSensorEventToListeners(event)
        pump()
    }

    private fun isTurned(before: DoubleArray): Boolean {
        val now = session.place()!!
        return (3..6).any { Math.abs(now[it] - before[it]) > 0.1 } // the orientation
    }

    private fun turnsWithTheDevice(what: String) {
        val before = session.place()!!
        until("the view turns with the device $what") {
            turnDevice()
            isTurned(before)
        }
    }

    private fun staysAsTheDeviceTurns() {
        settled()
        val before = session.place()!!
        repeat(40) { turnDevice() }
        settled()
        assertFalse(isTurned(before))
    }

    @Test
    fun theDeviceLooksAroundAlsoAfterTheBenchmarkAndInAnotherScene() {
        shadowOf(sensors).addSensor(ShadowSensor.newInstance(Sensor.TYPE_GAME_ROTATION_VECTOR))
        openAndDraw()
        staysAsTheDeviceTurns()
        press(R.id.gyroscope)
        turnsWithTheDevice("once it is switched on")
        val surface = activity.view(R.id.surface)
        assertTrue("the screen stays on", surface.keepScreenOn)
        settled()
        pump(2 * ViewerActivity.LOOK_EVERY_MS) // the last turn has been seen
        pump(ViewerActivity.AWAKE_MS + 1000)
        assertFalse("but not while it lies on a table", surface.keepScreenOn)
        turnsWithTheDevice("in somebody's hand again")
        until("the screen stays on again") { surface.keepScreenOn }
        controller!!.pause().resume()
        turnsWithTheDevice("after a pause")
        more(R.id.measure)
        started()
        controller!!.pause().stop().restart().start().resume()
        until("the scene is there again") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        turnsWithTheDevice("after the benchmark")
        val other = Documents.offer(File(material, "scene.splat"))
        controller!!.pause().newIntent(Intent(context, ViewerActivity::class.java).setData(other)).resume()
        until("the other is drawn") {
            session.state()!!.loading.format == "splat" && !activity.isShown(R.id.loading)
        }
        turnsWithTheDevice("in another scene")
        press(R.id.gyroscope)
        staysAsTheDeviceTurns()
    }

    // Rest

    @Test
    fun nothingIsDoneWhileNothingMoves() {
        Settings(scale = 1f, sorter = 2, hud = true).save(context)
        openAndDraw()
        val surface = activity.view(R.id.surface) as SceneSurface
        until("it rests") { !surface.isAwake }
        var texts = 0
        val hud = activity.findViewById<android.widget.TextView>(R.id.hud)
        hud.addTextChangedListener(object : android.text.TextWatcher {
            override fun afterTextChanged(text: android.text.Editable?) { texts += 1 }
            override fun beforeTextChanged(text: CharSequence?, a: Int, b: Int, c: Int) = Unit
            override fun onTextChanged(text: CharSequence?, a: Int, b: Int, c: Int) = Unit
        })
        repeat(100) { pump() }
        assertFalse(surface.isAwake)
        assertTrue("the numbers are still: $texts", texts <= 1)
        val before = session.place()!!
        drag(320f to 240f, 420f to 250f)
        until("the scene moves") { !before.contentEquals(session.place()!!) }
        until("it rests again") { !surface.isAwake }
        more(R.id.flip)
        assertTrue(surface.isAwake)
    }

    @Test
    fun theScreenStaysOnForAWhileAfterATouch() {
        openAndDraw()
        val surface = activity.view(R.id.surface)
        pump(300)
        assertTrue(surface.keepScreenOn)
        pump(ViewerActivity.AWAKE_MS)
        assertFalse(surface.keepScreenOn)
        activity.onUserInteraction()
        pump(300)
        assertTrue(surface.keepScreenOn)
        pump(ViewerActivity.AWAKE_MS)
        session.flipUp() // as a turn of the device does, what is seen moves
        until("it is on again") { surface.keepScreenOn }
    }

    @Test
    fun aProblemDoesNotKeepTheScreenOn() {
        openAndFail(Documents.uri("gone"))
        pump(ViewerActivity.AWAKE_MS)
        assertFalse(activity.view(R.id.surface).keepScreenOn)
    }

    // Life

    @Test
    fun aSceneThatWasLookedAtIsRememberedWithItsImage() {
        openAndDraw()
        drag(320f to 240f, 380f to 240f)
        settled()
        val place = session.place()!!
        controller!!.pause()
        Background.start {}.get() // where the image is taken
        val recent = Recents(context).find(Scene.SAMPLE)!!
        assertEquals(28842L, recent.splats)
        assertNotNull(Recents(context).image(recent))
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
    fun theSceneThatWasOpenedLastSurvivesTheEndOfTheProcess() {
        openAndDraw()
        val other = Documents.offer(File(material, "scene.splat"))
        controller!!.newIntent(Intent(context, ViewerActivity::class.java).setData(other))
        until("the other is drawn") {
            session.state()!!.loading.format == "splat" && !activity.isShown(R.id.loading)
        }
        val before = settled()
        val state = Bundle()
        controller!!.pause().stop().saveInstanceState(state).destroy()
        controller = null
        start(Intent(context, ViewerActivity::class.java).setData(null), state)
        until("a scene is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
        assertEquals("splat", session.state()!!.loading.format)
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
        until("the image has the other shape") {
            pump()
            session.image()?.let { it.width == HEIGHT && it.height == WIDTH } == true
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

    /** The view of one scene is no place in another. */
    @Test
    fun theEndOfTheProcessWhileAnotherIsLoadedKeepsNoPlace() {
        openAndDraw()
        Documents.answers["slow"] = {
            ParcelFileDescriptor.open(
                File(material, "pipe"), ParcelFileDescriptor.MODE_READ_WRITE,
            )
        }
        val other = Documents.uri("slow")
        controller!!.newIntent(Intent(context, ViewerActivity::class.java).setData(other))
        until("it is read") { session.state()!!.loading.phase == "reading" }
        val state = Bundle()
        controller!!.pause().stop().saveInstanceState(state)
        assertEquals(other.toString(), state.getString("scene"))
        assertNull(state.getDoubleArray("place"))
    }

    @Test
    fun aSessionThatIsGoneDoesNothing() {
        openAndDraw()
        val gone = session
        close()
        gone.frame(1)
        gone.resetView()
        assertEquals(null, gone.state())
        assertEquals(null, gone.image())
    }
}
