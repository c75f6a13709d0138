package org.fluxgs.app

import android.content.Intent
import android.net.Uri
import android.os.BadParcelableException
import android.os.Build
import android.os.Bundle
import android.os.ParcelFileDescriptor
import android.os.PowerManager
import java.io.File
import org.json.JSONObject
import org.junit.After
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNull
import org.junit.Assert.assertTrue
import org.junit.Assert.fail
import org.junit.Assume.assumeTrue
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
import org.robolectric.shadows.ShadowLog

@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w411dp-h731dp-port-hdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class BenchmarkTest {
    private val context = RuntimeEnvironment.getApplication()
    private val own get() = context.getExternalFilesDir(null)!!
    private var controller: ActivityController<BenchmarkActivity>? = null
    private val activity get() = controller!!.get()

    @Before
    fun install() {
        pauseDisplay()
        Documents.install()
    }

    @After
    fun close() {
        controller?.end()
        controller = null
    }

    private fun intent(vararg extras: Pair<String, String>): Intent {
        val intent = Intent(context, BenchmarkActivity::class.java)
        for ((name, value) in extras) intent.putExtra(name, value)
        return intent
    }

    /** A scene of few splats, small images and few of them, so that the test is short. */
    private fun short(vararg extras: Pair<String, String>): Intent {
        File(material, "few.splat").copyTo(File(own, "few.splat"), true)
        return intent(
            "scene" to "few.splat", "sizes" to "96x64,64x96", "frames" to "3", "warmup" to "1", *extras,
        )
    }

    private fun start(intent: Intent, state: Bundle? = null) {
        controller = Robolectric.buildActivity(BenchmarkActivity::class.java, intent)
        if (state == null) controller!!.create() else controller!!.create(state)
        controller!!.start().resume().visible()
        pump()
        controller!!.windowFocusChanged(true)
    }

    private fun finished(): BenchmarkResult {
        until("the benchmark has ended", 200) { activity.result != null }
        Background.start {}.get() // what was found is written and compared there
        pump()
        return activity.result!!
    }

    private fun problem(intent: Intent): String {
        start(intent)
        until("it is said to have failed") { ShadowLog.getLogsForTag(BenchmarkActivity.TAG).isNotEmpty() }
        assertFalse(activity.isShown(R.id.results))
        return activity.text(R.id.status)
    }

    @Test
    fun aShellStartsItAndFindsTheResult() {
        File(material, "scene.glb").copyTo(File(own, "garden.glb"), true)
        start(short("scene" to "garden.glb", "json" to "out/garden.json"))
        finished()
        val file = File(own, "out/garden.json")
        val log = ShadowLog.getLogsForTag(BenchmarkActivity.TAG).last().msg
        assertEquals("done ${file.canonicalPath}", log)
        file.copyTo(File(material, "result.json"), true) // for the desktop's report
        val json = JSONObject(file.readText())
        assertEquals("garden.glb", json.getJSONObject("scene").getString("name"))
        assertEquals(28842, json.getJSONObject("scene").getInt("splats"))
        assertEquals(3, json.getJSONObject("protocol").getInt("frames"))
        assertEquals("", json.getString("stopped"))
        val rows = json.getJSONArray("rows")
        assertEquals("2 sizes, 2 sorters, still views and a path", 8, rows.length())
        for (i in 0 until rows.length()) {
            val row = rows.getJSONObject(i)
            assertTrue(row.getJSONObject("draw_ms").getDouble("median") > 0)
            val sorted = row.getJSONObject("sort_to_display_ms")
            assertTrue(sorted.getDouble("p95") >= sorted.getDouble("median"))
        }
        assertTrue(json.getJSONObject("driver").getString("renderer").isNotEmpty())
        assertTrue(json.getJSONObject("driver_check").getBoolean("right"))
        assertTrue(json.getJSONObject("driver").getJSONArray("extensions").length() > 10)
        val table = File(own, "out/garden.csv").readLines()
        assertEquals(1 + rows.length(), table.size)
        assertEquals(table[0].count { it == ',' }, table[8].count { it == ',' })
        assertTrue(table[1], table[1].startsWith("garden.glb,28842,"))
    }

    @Test
    fun aShellSaysWhatTheSceneIsCalled() {
        start(short("name" to "garden, \"mine\".glb"))
        assertEquals("garden, \"mine\".glb", finished().sceneName)
        val line = activity.result!!.csv().lines()[1]
        assertTrue(line, line.startsWith("\"garden, \"\"mine\"\".glb\",1000,"))
    }

    @Test
    fun itsSelfTestIsTheDesktops() {
        assumeTrue("the native library is the same on all of them", Build.VERSION.SDK_INT >= 29)
        start(short("scene" to "sample"))
        val found = finished().json.getJSONObject("self_test")
        val desktop = JSONObject(File(material, "sample.json").readText()).getJSONObject("self_test")
        for (key in listOf("splats", "decoded", "sorted", "projected"))
            assertEquals(key, desktop.get(key).toString(), found.get(key).toString())
    }

    @Test
    fun theResultIsShownWithAChart() {
        start(short("sizes" to "320x240"))
        finished()
        pump()
        assertTrue(activity.isShown(R.id.results))
        val chart = activity.view(R.id.chart)
        assertTrue(chart.contentDescription.contains("320×240"))
        assertTrue(activity.text(R.id.facts).contains("Android"))
        close()
        // The second has the first to compare with
        start(short("sizes" to "320x240"))
        finished()
        repeat(5) { pump() }
        assertTrue(activity.text(R.id.facts).contains("times as fast"))
        val fps = activity.text(R.id.big).removeSuffix(" fps").replace(",", "").toLong()
        assertEquals(Math.round(activity.result!!.rows[0].drawFps), fps)
        assertTrue("139" in activity.text(R.id.legend_paper))
        assertTrue(activity.isShown(R.id.legend_before))
        keep(screenOf(activity, null), "benchmark")
    }

    @Test
    fun itSaysWhatWasNotTheSameInTheRunComparedWith() {
        start(short())
        val first = finished()
        val unlike = context.getString(R.string.compared_unlike, "").trim()
        close()
        start(short("frames" to "4"))
        val second = finished()
        assertEquals(listOf("protocol.frames"), second.differences(first))
        val other = BenchmarkResult(JSONObject(first.json.toString()))
        other.json.getJSONObject("scene").put("bytes", 7)
        other.json.getJSONObject("device").put("android", "99")
        assertEquals(listOf("scene.bytes", "device.android"), first.differences(other))
        val facts = activity.text(R.id.facts)
        assertTrue(facts, "times as fast" in facts)
        assertTrue(facts, "$unlike ${context.getString(R.string.condition_frames)}" in facts)
        close()
        // The third is compared with the first, which was measured likewise
        start(short())
        val third = finished()
        assertEquals(first.text(), BenchmarkHistory(context).before(third)!!.text())
        assertFalse(activity.text(R.id.facts), unlike in activity.text(R.id.facts))
        val table = third.csv().lines()
        assertEquals("false", table[1].split(',')[table[0].split(',').indexOf("multi_window")])
    }

    /** Two copies of a scene would not find room where one does. */
    @Test
    fun againMakesRoomFirst() {
        start(short())
        finished()
        val field = BenchmarkActivity::class.java.getDeclaredField("session").apply { isAccessible = true }
        val first = field.get(activity) as Session
        activity.view(R.id.again).performClick()
        assertNull("the scene is gone", first.state())
        assertEquals("", finished().stopped)
        val second = field.get(activity) as Session
        activity.finish()
        controller!!.pause() // the viewer may resume before this one is destroyed
        assertNull(second.state())
    }

    @Test
    fun progressIsShown() {
        start(intent("sizes" to "640x480", "frames" to "20"))
        until("there is progress", 100) { activity.text(R.id.status).contains("left") }
        keep(screenOf(activity, null), "benchmark-running")
        activity.view(R.id.stop).performClick()
        assertEquals(context.getString(R.string.stopped_by_user), finished().stopped)
        assertTrue(activity.text(R.id.status).contains(context.getString(R.string.stopped_by_user)))
    }

    @Test
    fun aCallInBetweenIsMarked() {
        start(intent("sizes" to "640x480", "frames" to "50"))
        until("it runs", 100) { activity.text(R.id.status).contains("left") }
        controller!!.pause().stop()
        assertEquals(context.getString(R.string.stopped_by_leaving), finished().stopped)
        assertTrue(activity.result!!.csv().trim().endsWith(",".repeat(13)))
        assertTrue(context.getString(R.string.stopped_by_leaving) in activity.result!!.csv())
        close()
        start(short())
        assertNull("no whole run to compare with", BenchmarkHistory(context).before(finished()))
    }

    @Test
    fun whoLeavesItWhileItRunsIsToldAbout() {
        start(intent("sizes" to "640x480", "frames" to "50"))
        until("it runs", 100) { activity.text(R.id.status).contains("left") }
        close()
        assertTrue("failed" in ShadowLog.getLogsForTag(BenchmarkActivity.TAG).last().msg)
    }

    /** A window of another app, or the system's, over this one or beside it. */
    @Test
    fun whatComesInFrontIsMarked() {
        start(intent("sizes" to "640x480", "frames" to "50"))
        until("it runs", 100) { activity.text(R.id.status).contains("left") }
        controller!!.windowFocusChanged(false)
        assertEquals(context.getString(R.string.stopped_by_covering), finished().stopped)
        close()
        start(intent("sizes" to "640x480", "frames" to "50"))
        until("it runs", 100) { activity.text(R.id.status).contains("left") }
        controller!!.pause() // and no more
        assertEquals(context.getString(R.string.stopped_by_leaving), finished().stopped)
    }

    @Test
    fun leavingWhileItOpensMeasuresNothing() {
        start(short())
        controller!!.pause().stop()
        pump(500)
        assertTrue(activity.text(R.id.status).contains(context.getString(R.string.stopped_by_leaving)))
        assertNull(activity.result)
        controller!!.start().resume()
        activity.view(R.id.retry).performClick()
        assertEquals("", finished().stopped)
    }

    @Test
    fun heatEndsItAndIsMarked() {
        assumeTrue("Android tells how warm it is from API 29 on", Build.VERSION.SDK_INT >= 29)
        val power = context.getSystemService(PowerManager::class.java)
        start(intent("sizes" to "640x480", "frames" to "50"))
        until("it runs", 100) { activity.text(R.id.status).contains("left") }
        shadowOf(power).setCurrentThermalStatus(PowerManager.THERMAL_STATUS_SEVERE)
        val found = finished()
        assertTrue(found.stopped, found.stopped.contains("3"))
        assertEquals(3, found.json.getJSONObject("thermal").getJSONObject("after").getInt("status"))
        assertEquals(0, found.json.getJSONObject("thermal").getJSONObject("before").getInt("status"))
    }

    @Test
    fun theResultCanBeShared() {
        start(short())
        finished()
        for ((button, type) in listOf(R.id.share_json to "application/json", R.id.share_csv to "text/csv")) {
            activity.view(button).performClick()
            Background.start {}.get()
            pump()
            val chooser = shadowOf(activity).nextStartedActivity
            @Suppress("DEPRECATION")
            val send = chooser.getParcelableExtra<Intent>(Intent.EXTRA_INTENT)!!
            assertEquals(type, send.type)
            @Suppress("DEPRECATION")
            val uri = send.getParcelableExtra<Uri>(Intent.EXTRA_STREAM)!!
            val text = context.contentResolver.openInputStream(uri)!!.reader().readText()
            if (type == "text/csv") assertEquals(9, text.trim().lines().size)
            else assertEquals(8, JSONObject(text).getJSONArray("rows").length())
        }
    }

    @Test
    fun theResultSurvivesTheEndOfTheProcess() {
        start(short())
        finished()
        close()
        start(short())
        val before = finished().json.toString()
        val facts = activity.text(R.id.facts)
        assertTrue(facts, "times as fast" in facts)
        val state = Bundle()
        controller!!.pause().stop().saveInstanceState(state).destroy()
        controller = null
        start(short(), state)
        Background.start {}.get()
        pump()
        assertEquals(before, activity.result!!.json.toString())
        assertEquals("with what it was compared with", facts, activity.text(R.id.facts))
    }

    @Test
    fun oneSorterOnly() {
        start(short("sorter" to "cpu"))
        assertEquals(4, finished().rows.size)
    }

    @Test
    fun frontToBackInSlices() {
        start(short("slices" to "8"))
        val slices = finished().json.getJSONArray("rows").getJSONObject(0).getInt("slices")
        assertTrue("$slices", slices == 8 || slices == 1)  // not every driver can
    }

    @Test
    fun nonsenseOfAShellIsSaidToBe() {
        val bad = listOf(
            intent("frames" to "many") to "frames 'many'",
            intent("frames" to "0") to "frames '0'",
            intent("sizes" to "12") to "size '12'",
            intent("sizes" to "99999x1") to "size '99999x1'",
            intent("sorter" to "both-of-them") to "sorter",
            intent("slices" to "65") to "slices '65'",
            intent("scene" to "nothing.glb") to "nothing.glb",
            intent("scene" to "../../../../etc/passwd") to "not inside",
            intent("json" to "../../escaped.json") to "not inside",
            intent("json" to "garden.glb") to "does not end in .json",
            intent("json" to "x".repeat(5000) + ".json") to "too long",
            intent("scene" to "nothing\u0000.glb") to "nvalid",
        )
        for ((wrong, said) in bad) {
            val message = problem(wrong)
            assertTrue(message, message.contains(said))
            close()
            ShadowLog.clear()
        }
    }

    @Test
    fun aSceneThatIsNoneIsSaidToBe() {
        File(own, "letter.glb").writeText("dear scene")
        val message = problem(intent("scene" to "letter.glb"))
        assertTrue(message, message.contains("format"))
    }

    /** Extras of a class that only another app has, which Android 8 to 12 cannot even look into. */
    @Test
    fun extrasOfAnotherAppsOwnMakingAreNoCrash() {
        val rude = object : Intent(context, BenchmarkActivity::class.java) {
            override fun getStringExtra(name: String): String = throw BadParcelableException("Theirs")
        }
        val message = problem(rude)
        assertTrue(message, message.contains("Theirs"))
    }

    @Test
    fun itWaitsForWhatLiesOverTheApp() {
        start(short())
        controller!!.windowFocusChanged(false)
        val waits = context.getString(R.string.waiting_for_focus)
        until("it waits", 100) { activity.text(R.id.status) == waits }
        controller!!.windowFocusChanged(true)
        assertEquals("", finished().stopped)
    }

    @Test
    fun theScreenStaysOnWhileItMeasuresOnly() {
        start(intent("sizes" to "640x480", "frames" to "50"))
        val bar = activity.view(R.id.bar)
        until("it runs", 100) { activity.text(R.id.status).contains("left") }
        assertTrue(bar.keepScreenOn)
        activity.view(R.id.stop).performClick()
        finished()
        assertFalse(bar.keepScreenOn)
        close()
        problem(intent("scene" to "nothing.glb"))
        assertFalse(activity.view(R.id.bar).keepScreenOn)
    }
}
