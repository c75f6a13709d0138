package org.fluxgs.app

import android.app.Activity
import android.content.Intent
import android.net.Uri
import android.os.BadParcelableException
import android.os.Bundle
import android.os.Handler
import android.os.Looper
import android.os.ParcelFileDescriptor
import android.util.Log
import android.view.View
import android.widget.Button
import android.widget.ProgressBar
import android.widget.TextView
import java.io.File
import java.io.IOException
import java.util.concurrent.FutureTask
import kotlin.concurrent.thread
import kotlin.math.roundToLong
import org.json.JSONObject

/**
 * The benchmark: off the screen, so that no display limits it. Also from a shell:
 *
 *     adb shell am start -S -W -n org.fluxgs.app/.BenchmarkActivity -e scene garden.glb -e json garden.json
 *
 * Both are names of files in the app's own folder on the device (Android/data/org.fluxgs.app/files), the
 * result's one that ends in .json; without a scene it is the sample. `-e name` is what the result calls it.
 * The log (tag FluxGsBenchmark) says "done FILE" or "failed REASON".
 */
class BenchmarkActivity : Activity() {
    private lateinit var session: Session
    private lateinit var plan: BenchmarkPlan
    private lateinit var uri: Uri
    private var wanted: File? = null // where the result is to be written, too
    private lateinit var thermals: Thermals
    private lateinit var status: TextView
    private lateinit var bar: ProgressBar
    private val main = Handler(Looper.getMainLooper())
    private var opening: SceneOpening? = null
    private var report: BenchmarkReport? = null
    private var before = Heat()
    private var name = ""
    private var began = 0L
    private var selfTest: FutureTask<JSONObject>? = null
    private var inFront = false // nothing lies over this
    private var preparing = false // opening, loading, testing: nothing is measured yet
    internal var result: BenchmarkResult? = null
        private set

    private val look = object : Runnable {
        override fun run() {
            // Seldom while it measures: what is shown of it takes a part of the GPU
            if (!advance()) return
            main.postDelayed(this, if (report == null) LOOK_EVERY_MS else LOOK_WHILE_MEASURING_MS)
        }
    }

    override fun onCreate(state: Bundle?) {
        super.onCreate(state)
        setContentView(R.layout.benchmark)
        Insets.pad(findViewById(R.id.root))
        status = findViewById(R.id.status)
        bar = findViewById(R.id.bar)
        thermals = Thermals(this)
        session = Session()
        findViewById<Button>(R.id.stop).setOnClickListener {
            stop(getString(R.string.stopped_by_user))
        }
        findViewById<Button>(R.id.share_json).setOnClickListener { share("json") }
        findViewById<Button>(R.id.share_csv).setOnClickListener { share("csv") }
        for (id in listOf(R.id.again, R.id.retry))
            findViewById<Button>(id).setOnClickListener { begin() }
        try {
            plan = BenchmarkPlan.of(intent)
            uri = sceneOf(intent)
            wanted = intent.getStringExtra("json")?.let { resultNamed(it) }
        } catch (problem: IllegalArgumentException) {
            return refuse(problem)
        } catch (problem: BadParcelableException) { // extras of somebody else's own making
            return refuse(problem)
        } catch (problem: IOException) { // no file can have that name
            return refuse(problem)
        }
        val kept = state?.getString(RESULT)?.let { BenchmarkResult.of(it) }
        if (kept == null) return begin()
        result = kept
        Background.start { compare(kept) }
    }

    private fun refuse(problem: Exception) {
        fail(problem.message ?: problem.toString())
        findViewById<View>(R.id.retry).visibility = View.GONE
    }

    /** A name is of a file in the app's folder; there is no way out of it. */
    private fun ownFile(name: String): File {
        val folder = (getExternalFilesDir(null) ?: filesDir).canonicalFile
        val file = File(folder, name).canonicalFile
        require(file.path.startsWith(folder.path + File.separator)) {
            "'$name' is not inside of $folder"
        }
        return file
    }

    /** Whoever starts this activity must not write over anything else. */
    private fun resultNamed(name: String): File {
        require(name.endsWith(".json")) { "json '$name' does not end in .json" }
        return ownFile(name)
    }

    private fun sceneOf(intent: Intent): Uri {
        val scene = intent.getStringExtra("scene") ?: return intent.data ?: Scene.SAMPLE
        if (scene == "sample") return Scene.SAMPLE
        val file = ownFile(scene)
        require(file.isFile) { "there is no $file: push the scene there first" }
        return Uri.fromFile(file)
    }

    private fun begin() {
        if (opening != null) dropScene()
        result = null
        preparing = true
        selfTest = null
        findViewById<View>(R.id.results).visibility = View.GONE
        findViewById<View>(R.id.retry).visibility = View.GONE
        findViewById<View>(R.id.running).visibility = View.VISIBLE
        bar.visibility = View.VISIBLE
        bar.isIndeterminate = true
        bar.keepScreenOn = true
        status.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_NONE // it counts
        status.text = getString(R.string.opening)
        report = null
        opening = SceneOpening(this, uri, { descriptor, facts ->
            name = intent.getStringExtra("name") ?: facts.name
            load(descriptor, facts.bytes)
        }, { fail(it.message, it.cause) }, { status.text = getString(R.string.provider_slow) })
        opening?.start()
    }

    /** The scene holds memory that the next one needs. */
    private fun dropScene() {
        session.close()
        session = Session()
    }

    private fun load(descriptor: ParcelFileDescriptor, bytes: Long) {
        session.load(descriptor.detachFd(), name, bytes, FreeMemory.forScene(this), null)
        main.removeCallbacks(look)
        main.post(look)
    }

    private fun startSelfTest(): FutureTask<JSONObject> {
        status.text = getString(R.string.testing, name)
        val of = session
        return FutureTask {
            DriverCheck.of(applicationContext, anew = true)
            of.selfTest()
        }.also { thread(name = "self-test", isDaemon = true) { it.run() } }
    }

    private fun stop(reason: String) {
        if (!preparing) return session.stopBenchmark(reason)
        opening?.cancel()
        session.cancelLoading()
        main.removeCallbacks(look)
        fail(reason)
    }

    /** True if there is more to wait for. */
    private fun advance(): Boolean {
        val state = session.state() ?: return false
        val loading = state.loading
        if (loading.failed) return fail(getString(R.string.scene_unreadable), loading.error)
        if (!loading.ready) return true
        val test = selfTest ?: startSelfTest().also { selfTest = it }
        if (!test.isDone) return true // it takes the processor
        if (report == null && !start()) return true
        val outcome = session.benchmark() ?: return false
        if (outcome.getString("error").isNotEmpty()) return fail(outcome.getString("error"))
        if (!outcome.getBoolean("running")) return finishWith(outcome, state)
        watchHeat()
        showProgress(outcome)
        return true
    }

    /** Once nothing lies over the app, which would take a part of the GPU. */
    private fun start(): Boolean {
        if (!inFront) {
            status.text = getString(R.string.waiting_for_focus)
            return false
        }
        preparing = false
        report = BenchmarkReport(this, plan, isInMultiWindowMode)
        began = System.nanoTime()
        before = thermals.now()
        status.text = getString(R.string.benchmark_begins, name)
        bar.isIndeterminate = false // nothing moves but what is measured
        bar.progress = 0
        session.startBenchmark(plan)
        return true
    }

    private fun watchHeat() {
        val heat = thermals.now()
        if (heat.status >= Thermals.SEVERE)
            stop(getString(R.string.stopped_by_heat, heat.status))
    }

    private fun showProgress(outcome: JSONObject) {
        val done = outcome.getInt("done")
        val all = outcome.getInt("all")
        if (all == 0) return
        bar.max = all
        bar.progress = done
        val left = VideoExport.secondsLeft((System.nanoTime() - began) / 1_000_000, done, all)
        val frames = getString(R.string.benchmark_progress, name, done, all)
        status.text = listOfNotNull(frames, left?.let { Texts.left(this, it) }).joinToString(" · ")
    }

    private fun finishWith(outcome: JSONObject, state: SessionState): Boolean {
        val found = report!!.result(
            outcome, state, session.driver(), name, before, thermals.now(), selfTest!!.get(),
        )
        result = found
        session.close() // another app may want the memory
        bar.keepScreenOn = false
        Background.start {
            orTellTheLog { BenchmarkHistory(this).add(found) }
            wanted?.let { orTellTheLog { writeTo(it, found) } }
            compare(found)
        }
        return false
    }

    /** In the background: reads the earlier results. */
    private fun compare(found: BenchmarkResult) {
        val earlier = BenchmarkHistory(this).before(found)
        runOnUiThread { if (result === found) show(found, earlier) }
    }

    private inline fun orTellTheLog(work: () -> Unit) = try {
        work()
    } catch (problem: IOException) {
        Log.e(TAG, "failed ${problem.message}")
    }

    /** Writes garden.csv beside garden.json. */
    private fun writeTo(file: File, found: BenchmarkResult) {
        write(File(file.path.removeSuffix(".json") + ".csv"), found.csv())
        write(file, found.text())
        Log.i(TAG, "done ${file.path}")
    }

    private fun write(file: File, text: String) {
        file.parentFile?.mkdirs()
        val part = File(file.path + ".part")
        part.writeText(text)
        if (!part.renameTo(file)) throw IOException("$file cannot be written")
    }

    /** [cause]: as the machine has it. */
    private fun fail(message: String, cause: String = ""): Boolean {
        preparing = false
        Log.e(TAG, "failed ${cause.ifEmpty { message }}")
        bar.visibility = View.GONE
        bar.keepScreenOn = false
        findViewById<View>(R.id.running).visibility = View.GONE
        findViewById<View>(R.id.retry).visibility = View.VISIBLE
        say(listOf(getString(R.string.benchmark_failed, message), cause).filter { it.isNotEmpty() }.joinToString("\n"))
        return false
    }

    private fun show(found: BenchmarkResult, earlier: BenchmarkResult?) {
        bar.visibility = View.GONE
        findViewById<View>(R.id.running).visibility = View.GONE
        findViewById<View>(R.id.results).visibility = View.VISIBLE
        say(headline(found))
        findViewById<BenchmarkChart>(R.id.chart).show(found.rows, earlier?.rows ?: emptyList())
        showBig(found)
        showLegend(earlier)
        findViewById<TextView>(R.id.facts).text = facts(found, earlier)
    }

    /** What the benchmark is about: the median of the first size, as the paper measures. */
    private fun showBig(found: BenchmarkResult) {
        val row = found.rows.firstOrNull()
        findViewById<View>(R.id.big).visibility = if (row == null) View.GONE else View.VISIBLE
        findViewById<View>(R.id.big_of).visibility = if (row == null) View.GONE else View.VISIBLE
        if (row == null) return
        findViewById<TextView>(R.id.big).text = getString(R.string.benchmark_big, Texts.count(row.drawFps.roundToLong()))
        findViewById<TextView>(R.id.big_of).text = getString(R.string.benchmark_of, row.label(this))
    }

    private fun showLegend(earlier: BenchmarkResult?) {
        findViewById<TextView>(R.id.legend_paper).text =
            getString(R.string.legend_paper, Texts.count(BenchmarkChart.PAPER_FPS.toLong()))
        findViewById<TextView>(R.id.legend_before).apply {
            visibility = if (earlier == null) View.GONE else View.VISIBLE
            if (earlier != null) text = getString(R.string.legend_before, earlier.startedHere)
        }
    }

    /** Read out, too. */
    private fun say(text: String) {
        status.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_POLITE
        status.text = text
    }

    private fun headline(found: BenchmarkResult): String {
        val line = getString(R.string.benchmark_done, Texts.titleOf(found.sceneName), Texts.splats(this, found.splats))
        return if (found.stopped.isEmpty()) line
        else line + "\n" + getString(R.string.benchmark_stopped, found.stopped)
    }

    private fun facts(found: BenchmarkResult, earlier: BenchmarkResult?): String {
        val device = found.json.getJSONObject("device")
        val driver = found.json.optJSONObject("driver")
        val thermal = found.json.getJSONObject("thermal")
        val lines = mutableListOf(
            "${nameOf(device)}, Android ${device.getString("android")}",
            driver?.let { "${it.getString("renderer")}, ${it.getString("version")}" } ?: "",
            DriverCheck.textOf(this),
            found.blendedIn?.let { getString(R.string.blended_in, it) } ?: "",
            thermalLine(
                thermal.getJSONObject("before").getInt("status"),
                thermal.getJSONObject("after").getInt("status"),
            ),
        )
        if (earlier != null) lines += comparison(found, earlier)
        if (found.json.optBoolean("multi_window")) lines += getString(R.string.beside_another)
        if (BuildFacts.isCheckBuild) lines += getString(R.string.check_build)
        return lines.filter { it.isNotEmpty() }.joinToString("\n")
    }

    /** Many makers begin the model with their own name. */
    private fun nameOf(device: JSONObject): String {
        val maker = device.getString("manufacturer").replaceFirstChar { it.uppercase() }
        val model = device.getString("model")
        return if (model.startsWith(maker, ignoreCase = true)) model else "$maker $model"
    }

    private fun comparison(found: BenchmarkResult, earlier: BenchmarkResult): List<String> {
        val ratios = found.rows.mapNotNull { found.ratioTo(earlier, it) }.sorted()
        if (ratios.isEmpty()) return emptyList()
        val line = getString(R.string.compared, ratios[ratios.size / 2])
        val unlike = found.differences(earlier).mapNotNull { CONDITION_NAMES[it] }.distinct()
        if (unlike.isEmpty()) return listOf(line)
        return listOf(line, getString(R.string.compared_unlike, unlike.joinToString { getString(it) }))
    }

    private fun thermalLine(before: Int, after: Int) =
        if (before < 0 || after < 0) getString(R.string.thermal_unknown)
        else getString(R.string.thermal_line, before, after)

    private fun share(kind: String) {
        val found = result ?: return
        val base = found.sceneName.substringBeforeLast('.').replace(Regex("[^A-Za-z0-9._-]+"), "-")
        val type = if (kind == "csv") "text/csv" else "application/json"
        Background.start {
            try {
                val file = SharedFiles.create(this, "benchmark-$base.$kind")
                file.writeText(if (kind == "csv") found.csv() else found.text())
                val intent = SharedFiles.send(this, SharedFiles.uriOf(this, file), type)
                runOnUiThread { if (!isDestroyed) startActivity(intent) }
            } catch (problem: IOException) {
                runOnUiThread { status.text = getString(R.string.benchmark_failed, problem.message) }
            }
        }
    }

    /** A call, another app, also beside this one: what is measured from now on would be of that. */
    override fun onPause() {
        stop(getString(R.string.stopped_by_leaving))
        if (isFinishing) session.close() // the viewer opens the scene again before this is destroyed
        super.onPause()
    }

    /** The same of what only lies over this one. */
    override fun onWindowFocusChanged(has: Boolean) {
        super.onWindowFocusChanged(has)
        inFront = has
        if (!has && report != null) stop(getString(R.string.stopped_by_covering))
    }

    override fun onSaveInstanceState(state: Bundle) {
        super.onSaveInstanceState(state)
        result?.let { state.putString(RESULT, it.json.toString()) }
    }

    override fun onDestroy() {
        main.removeCallbacks(look)
        if (report != null && result == null) Log.e(TAG, "failed the app was left")
        opening?.cancel()
        session.close()
        super.onDestroy()
    }

    internal companion object {
        const val TAG = "FluxGsBenchmark"
        private const val LOOK_EVERY_MS = 100L
        private const val LOOK_WHILE_MEASURING_MS = 1000L
        private const val RESULT = "result"
        private val CONDITION_NAMES = mapOf(
            "protocol.warmup" to R.string.condition_frames,
            "protocol.frames" to R.string.condition_frames,
            "multi_window" to R.string.condition_screen,
            "app.name" to R.string.condition_app,
            "driver.version" to R.string.condition_driver,
            "thermal.before.status" to R.string.condition_heat,
            "scene.bytes" to R.string.condition_scene,
            "device.android" to R.string.condition_android,
        )
    }
}
