package org.fluxgs.app

import android.annotation.SuppressLint
import android.content.Context
import android.os.Build
import android.util.Log
import org.json.JSONArray
import org.json.JSONException
import org.json.JSONObject

/**
 * Whether the graphics driver of this device draws the sample as it looks, and what the renderer must do
 * without for that. Checked once for an installation of the app, a system and a driver; kept with
 * GL_RENDERER and GL_VERSION, which change with the driver alone.
 */
internal class DriverCheck(val json: JSONObject) {
    val right get() = json.optBoolean("right")
    val renderer: String get() = json.optString("renderer")
    val version: String get() = json.optString("version")
    val psnr get() = json.optDouble("psnr", 0.0)
    val faults: List<String> get() = texts("faults")

    /** Names of what the renderer does without (render/driver_limits.h). */
    val limits: List<String> get() = texts("limits")

    private val driver get() = "$renderer, $version"

    private fun texts(name: String): List<String> {
        val list = json.optJSONArray(name) ?: JSONArray()
        return (0 until list.length()).map { list.getString(it) }
    }

    companion object {
        private const val TAG = "FluxGsDriver"

        /** Checks that did not return, after which no other is tried: one may have been ended by a person. */
        private const val MAX_DEATHS = 2
        private const val DIED = "the driver ended the app while it was checked"

        @Volatile
        var now: DriverCheck? = null
            private set

        /**
         * The check of this device, made where there is none yet, or [anew]. Null where there is no
         * OpenGL ES 3.1. May take seconds: not for the main thread.
         */
        @Synchronized
        fun of(context: Context, anew: Boolean = false): DriverCheck? {
            now?.let { if (!anew) return it }
            val kept = Kept(context)
            val dies = kept.deaths >= MAX_DEATHS && !anew
            val found = if (dies) afterDeaths() else check(context, kept, anew)
            if (found != null) Log.i(TAG, found.json.toString())
            now = found
            return found
        }

        /** For tests: as in a new process. */
        internal fun forget() {
            now = null
        }

        /** [DriverCheck.now] for people. */
        fun textOf(context: Context): String {
            val check = now ?: return context.getString(R.string.driver_unchecked)
            if (!check.right) return context.getString(R.string.driver_wrong, faultOf(context, check))
            if (check.limits.isEmpty()) return context.getString(R.string.driver_right, check.psnr)
            val without = check.limits.joinToString { LIMIT_NAMES[it]?.let(context::getString) ?: it }
            return context.getString(R.string.driver_limited, without)
        }

        private fun faultOf(context: Context, check: DriverCheck): String {
            val fault = check.faults.lastOrNull() ?: ""
            return if (fault == DIED) context.getString(R.string.driver_died) else fault
        }

        private val LIMIT_NAMES = mapOf(
            "no_gpu_sort" to R.string.limit_gpu_sort,
            "no_vertex_storage" to R.string.limit_vertex_storage,
            "no_float_targets" to R.string.limit_float_targets,
            "no_compute" to R.string.limit_compute,
            "no_fragment_projection" to R.string.limit_fragment_projection,
        )

        private fun check(context: Context, kept: Kept, anew: Boolean): DriverCheck? {
            val known = if (anew) null else kept.check
            return try {
                val scene = context.assets.open("sample.glb").use { it.readBytes() }
                val golden = context.assets.open("sample.webp").use { it.readBytes() }
                kept.begin()
                val text = Native.checkDriver(scene, golden, known?.driver ?: "")
                if (text.isEmpty()) known else DriverCheck(JSONObject(text)).also { kept.check = it }
            } catch (problem: RuntimeException) {
                Log.e(TAG, "not checked: ${problem.message}")
                null
            } finally {
                kept.end()
            }
        }

        /** The driver ended the process: what is left is the plainest way of drawing. */
        /** The plainest way, which projects in fragment shaders. */
        private fun afterDeaths() = DriverCheck(
            JSONObject()
                .put("right", false)
                .put("limits", JSONArray(LIMIT_NAMES.keys - "no_fragment_projection"))
                .put("faults", JSONArray(listOf(DIED))),
        )
    }

    /** What is kept between processes, of this installation and system only. */
    private class Kept(context: Context) {
        private val of = "${BuildFacts.installed(context)}, ${Build.FINGERPRINT}"
        private val values = context.getSharedPreferences("driver", Context.MODE_PRIVATE)

        init {
            if (values.getString("of", null) != of) values.edit().clear().putString("of", of).apply()
        }

        val deaths get() = values.getInt("deaths", 0)

        var check: DriverCheck?
            get() = try {
                values.getString("check", null)?.let { DriverCheck(JSONObject(it)) }
            } catch (_: JSONException) {
                null
            }
            set(value) = values.edit().putString("check", value?.json?.toString()).apply()

        @SuppressLint("ApplySharedPref") // it must be on the disk before the driver is asked
        fun begin() {
            values.edit().putInt("deaths", deaths + 1).commit()
        }

        fun end() = values.edit().putInt("deaths", 0).apply()
    }
}
