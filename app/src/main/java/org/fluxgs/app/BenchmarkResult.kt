package org.fluxgs.app

import android.annotation.TargetApi
import android.app.ActivityManager
import android.content.Context
import android.os.Build
import java.io.File
import java.io.IOException
import java.text.DateFormat
import java.text.ParseException
import java.text.SimpleDateFormat
import java.util.Date
import java.util.Locale
import java.util.TimeZone
import org.json.JSONArray
import org.json.JSONException
import org.json.JSONObject

/** A line of a result: one size, sorter and kind of views. */
data class BenchmarkRow(
    val size: String,
    val views: String, // "still" or "path"
    val sorter: String, // "gpu" or "cpu"
    val drawMs: Double,
    val sortToDisplayMs: Double,
    val pipelinedMs: Double,
) {
    val drawFps get() = fps(drawMs)
    val sortToDisplayFps get() = fps(sortToDisplayMs)

    fun isLike(other: BenchmarkRow) = size == other.size && views == other.views && sorter == other.sorter

    /** For people. */
    fun label(context: Context): String = context.getString(
        R.string.chart_label, size,
        listOfNotNull(VIEWS[views], SORTERS[sorter]).joinToString { context.getString(it) },
    )

    private fun fps(ms: Double) = if (ms > 0) 1000 / ms else 0.0

    private companion object {
        val VIEWS = mapOf("still" to R.string.views_still, "path" to R.string.views_path)
        val SORTERS = mapOf("gpu" to R.string.sorted_by_gpu, "cpu" to R.string.sorted_by_cpu)
    }
}

/** The result of a benchmark as it is saved: one JSON object. */
internal class BenchmarkResult(val json: JSONObject) {
    val rows: List<BenchmarkRow> = json.getJSONArray("rows").let { rows ->
        (0 until rows.length()).map { rowOf(rows.getJSONObject(it)) }
    }
    val sceneName: String get() = json.getJSONObject("scene").getString("name")
    val splats: Long get() = json.getJSONObject("scene").getLong("splats")
    val stopped: String get() = json.getString("stopped")
    val started: String get() = json.getString("started")

    /** Format that layers are blended in: half floats move fewer bytes. */
    val blendedIn: String? get() =
        json.getJSONArray("rows").optJSONObject(0)?.optString("blended_in")?.ifEmpty { null }

    /** For people, in their time zone. */
    val startedHere: String get() {
        val then = try {
            format().parse(started)
        } catch (_: ParseException) {
            null
        } ?: return started
        return DateFormat.getDateTimeInstance(DateFormat.MEDIUM, DateFormat.SHORT).format(then)
    }

    fun text() = json.toString(1) + "\n"

    /** A line for each row, or one without measurements; each says of what, and why it ended early. */
    fun csv(): String {
        val rows = json.getJSONArray("rows")
        val of = RUN.map { quoted(find(json, it)) }
        val measured = (0 until rows.length()).map { i -> ROW.map { find(rows.getJSONObject(i), it) } }
        val lines = measured.ifEmpty { listOf(ROW.map { "" }) }.map { (of + it).joinToString(",") }
        return (listOf((RUN + ROW).joinToString(",")) + lines).joinToString("\n", postfix = "\n")
    }

    /** The value at a path such as draw_ms.median; nothing where an older app has written none. */
    private fun find(from: JSONObject, path: String): String {
        val names = path.split('.')
        val holder = names.dropLast(1).fold(from as JSONObject?) { at, name -> at?.optJSONObject(name) }
        return holder?.opt(names.last())?.toString() ?: ""
    }

    private fun quoted(text: String) =
        if (text.any { it in ",\"\n\r" }) "\"" + text.replace("\"", "\"\"") + "\"" else text

    /** The same measurement in an earlier result: how many times as fast this one is. */
    fun ratioTo(earlier: BenchmarkResult, row: BenchmarkRow): Double? {
        val before = earlier.rows.find { it.isLike(row) } ?: return null
        if (before.drawMs <= 0 || row.drawMs <= 0) return null
        return before.drawMs / row.drawMs
    }

    /** Differences that make an earlier result hard to compare: paths of the JSON. */
    fun differences(earlier: BenchmarkResult): List<String> =
        CONDITIONS.filter { find(json, it) != find(earlier.json, it) }

    /** True if the same was measured, and the whole screen was the app's both times. */
    fun isMeasuredLike(earlier: BenchmarkResult) = differences(earlier).none { it in PROTOCOL }

    private fun rowOf(row: JSONObject) = BenchmarkRow(
        "${row.getInt("width")}×${row.getInt("height")}", row.getString("views"), row.getString("sorter"),
        (row.optJSONObject("in_flight_ms") ?: row.getJSONObject("draw_ms")).getDouble("median"),
        row.getJSONObject("sort_to_display_ms").getDouble("median"),
        row.getDouble("pipelined_ms"),
    )

    companion object {
        const val VERSION = 1
        private val RUN = listOf(
            "scene.name", "scene.splats", "device.manufacturer", "device.model", "started",
            "app.name", "protocol.warmup", "protocol.frames", "multi_window",
            "thermal.before.status", "thermal.after.status", "stopped",
        )
        private val PROTOCOL = setOf("protocol.warmup", "protocol.frames", "multi_window")
        private val CONDITIONS = PROTOCOL + setOf(
            "scene.bytes", "app.name", "driver.version", "device.android", "thermal.before.status",
        )
        private val ROW = listOf(
            "width", "height", "views", "sorter", "in_flight_ms.median", "in_flight_ms.p95",
            "draw_ms.median", "draw_ms.p95",
            "sort_to_display_ms.median", "sort_to_display_ms.p95", "pipelined_ms", "splats_drawn",
            "fragments", "blended_in", "slices", "bytes_per_frame", "gpu_memory_bytes",
        )

        fun of(text: String): BenchmarkResult? = try {
            BenchmarkResult(JSONObject(text))
        } catch (_: JSONException) {
            null
        }

        /** ISO 8601. */
        private fun format() = SimpleDateFormat("yyyy-MM-dd'T'HH:mm:ss'Z'", Locale.ROOT)
            .apply { timeZone = TimeZone.getTimeZone("UTC") }

        fun time(): String = format().format(Date())

        fun deviceFacts(context: Context): JSONObject {
            val memory = ActivityManager.MemoryInfo()
            context.getSystemService(ActivityManager::class.java).getMemoryInfo(memory)
            return JSONObject()
                .put("manufacturer", Build.MANUFACTURER)
                .put("model", Build.MODEL)
                .put("soc", soc())
                .put("android", Build.VERSION.RELEASE)
                .put("sdk", Build.VERSION.SDK_INT)
                .put("abi", Build.SUPPORTED_ABIS.firstOrNull() ?: "")
                .put("cores", Runtime.getRuntime().availableProcessors())
                .put("memory_bytes", memory.totalMem)
        }

        @TargetApi(31)
        private fun soc() =
            if (Build.VERSION.SDK_INT >= 31) "${Build.SOC_MANUFACTURER} ${Build.SOC_MODEL}"
            else Build.HARDWARE
    }
}

/** The results that are kept, the newest first. */
internal class BenchmarkHistory(context: Context) {
    private val folder = File(context.filesDir, "benchmarks")

    /**
     * The last whole one of the same scene: of as many splats, too, for names are given anew. One that
     * was measured likewise, if there is.
     */
    fun before(result: BenchmarkResult): BenchmarkResult? {
        val known = files().mapNotNull { file -> read(file) }.filter {
            it.sceneName == result.sceneName && it.splats == result.splats && it.stopped.isEmpty() &&
                it.started <= result.started && it.text() != result.text()
        }
        return known.firstOrNull { result.isMeasuredLike(it) } ?: known.firstOrNull()
    }

    @Throws(IOException::class)
    fun add(result: BenchmarkResult) {
        folder.mkdirs()
        val next = (files().firstOrNull()?.nameWithoutExtension?.toLongOrNull() ?: 0) + 1
        File(folder, String.format(Locale.ROOT, "%06d.json", next))
            .writeText(result.text())
        files().drop(MOST).forEach { it.delete() }
    }

    private fun read(file: File) = try {
        BenchmarkResult.of(file.readText())
    } catch (_: IOException) {
        null
    }

    private fun files() = folder.listFiles()?.filter { it.name.endsWith(".json") }
        ?.sortedByDescending { it.name } ?: emptyList()

    private companion object {
        const val MOST = 50
    }
}

/** Puts a result together. */
internal class BenchmarkReport(
    private val context: Context,
    private val plan: BenchmarkPlan,
    private val besideAnother: Boolean, // in split screen
) {
    private val started = BenchmarkResult.time()
    private val since = System.nanoTime()

    fun result(
        outcome: JSONObject, state: SessionState, driver: JSONObject?, name: String, before: Heat,
        after: Heat, selfTest: JSONObject,
    ) = BenchmarkResult(
        JSONObject()
            .put("version", BenchmarkResult.VERSION)
            .put("app", BuildFacts.native.put("name", BuildFacts.version(context)))
            .put("device", BenchmarkResult.deviceFacts(context))
            .put("driver", driver ?: JSONObject.NULL)
            .put("driver_check", DriverCheck.now?.json ?: JSONObject.NULL)
            .put(
                "scene",
                JSONObject().put("name", name).put("bytes", state.loading.read)
                    .put("format", state.loading.format).put("splats", state.loading.splats),
            )
            .put("protocol", JSONObject().put("warmup", plan.warmup).put("frames", plan.frames))
            .put("thermal", JSONObject().put("before", before.toJson()).put("after", after.toJson()))
            .put("multi_window", besideAnother)
            .put("started", started)
            .put("seconds", (System.nanoTime() - since) / 1e9)
            .put("self_test", selfTest)
            .put("rows", outcome.optJSONArray("rows") ?: JSONArray())
            .put("stopped", outcome.getString("stopped")),
    )
}
