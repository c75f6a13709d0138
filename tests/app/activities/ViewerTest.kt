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
        assertTrue("fewer SH coefficients", psnr(before, settled()) < 45)
        dialog.findViewById<android.widget.Spinner>(R.id.budget).setSelection(4)
        assertFalse("no numbers for who does not ask", activity.isShown(R.id.hud))
        dialog.findViewById<android.widget.Switch>(R.id.hud).isChecked = true
        pump(300)
        assertTrue(activity.isShown(R.id.hud))
        dialog.dismiss()
        assertEquals(Settings(1f, 2, 0, 100_000, true), Settings.load(context))
        close()
        openAndDraw()
        pump(300)
        assertTrue(activity.isShown(R.id.hud))
    }

    private fun keepDialog(decor: View) {
        decor.measure(
            View.MeasureSpec.makeMeasureSpec(420, View.MeasureSpec.AT_MOST),
            View.MeasureSpec.makeMeasureSpec(900, View.MeasureSpec.AT_MOST),
        )
        decor.layout(0, 0, decor.measuredWidth, decor.measuredHeight)
        val image = Bitmap.createBitmap(decor.width, decor.height, Bitmap.Config.ARGB_8888)
        decor.draw(android.graphics.Canvas(image))
        keep(image, "settings")
    }

    @Test
    fun theNumbersSayWhatIsDrawn() {
        Settings(scale = 1f, sorter = 2, hud = true).save(context)
        openAndDraw()
        pump(300)
        val hud = activity.text(R.id.hud)
        assertTrue(hud, Regex("[\\d,]+ of 28,842 splats").containsMatchIn(hud))
        assertTrue(hud, Regex("[\\d.]+ ms").containsMatchIn(hud))
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
        press(R.id.measure)
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
        press(R.id.measure)
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
        press(R.id.flip)
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
