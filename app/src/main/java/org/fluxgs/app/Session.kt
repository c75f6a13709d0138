package org.fluxgs.app

import android.graphics.Bitmap
import android.util.Size
import android.view.Surface
import org.json.JSONObject
import java.util.concurrent.ConcurrentLinkedQueue
import kotlin.concurrent.thread

/** State of the native session, parsed. */
data class Loading(
    val phase: String,
    val read: Long,
    val bytes: Long,
    val error: String,
    val problem: String, // why it failed: "memory", "read", "open", or "" of what is no scene
    val format: String,
    val splats: Long,
    val memory: Long,
) {
    val isBusy get() = phase == "reading" || phase == "decoding"
    val failed get() = phase == "failed"
    val ready get() = phase == "ready"
}

/** Numbers for the HUD. */
data class Stats(
    val fps: Double, // 0 at rest
    val goal: Double, // frames a second that are aimed at
    val frameMs: Double,
    val sortMs: Double,
    val drawn: Long,
    val shown: Long,
    val splats: Long,
    val shDegree: Int, // that is shown
    val fileShDegree: Int,
    val width: Int,
    val height: Int,
    val scale: Double,
    val memory: Long, // bytes of graphics memory that are taken
    val reduced: Boolean, // there was no room for all splats and pixels, at the best precision
    val image: Double, // its width, of the window's: less where memory is short
    val coolest: Double, // the scale that heat allows
)

data class SessionState(
    val loading: Loading,
    val hasScene: Boolean,
    val drawn: Boolean,
    val coarse: Boolean, // what has come so far of a scene that is being opened
    val shown: Long, // the number of the loading whose scene it is, 0 for none
    val flipped: Boolean,
    val motion: String, // what moves the view by itself: "drift", "path", "walk", or nothing
    val error: String,
    val contexts: Int,
    val dropped: Long,
    val firstFrameMs: Double,
    val stats: Stats,
) {
    companion object {
        fun of(text: String): SessionState {
            val json = JSONObject(text)
            val loading = json.getJSONObject("loading")
            val stats = json.getJSONObject("stats")
            return SessionState(
                Loading(
                    loading.getString("phase"), loading.getLong("read"), loading.getLong("bytes"),
                    loading.getString("error"), loading.getString("problem"), loading.getString("format"),
                    loading.getLong("splats"), loading.getLong("memory"),
                ),
                json.getBoolean("hasScene"), json.getBoolean("drawn"), json.getBoolean("coarse"),
                json.getLong("shown"),
                json.getBoolean("flipped"), json.getString("motion"),
                json.getString("error"), json.getInt("contexts"), json.getLong("dropped"),
                json.getDouble("firstFrameMs"),
                Stats(
                    stats.getDouble("fps"), stats.getDouble("goal"), stats.getDouble("frameMs"), stats.getDouble("sortMs"),
                    stats.getLong("drawn"), stats.getLong("shown"), stats.getLong("splats"),
                    stats.getInt("shDegree"), stats.getInt("fileShDegree"),
                    stats.getInt("width"), stats.getInt("height"), stats.getDouble("scale"),
                    stats.getLong("memory"), stats.getBoolean("reduced"), stats.getDouble("image"),
                    stats.getDouble("coolest"),
                ),
            )
        }
    }
}

/**
 * Owns a native session. For the main thread, but for [image], [drawNow] and [selfTest]; does nothing once it is
 * closed.
 */
class Session : AutoCloseable {
    @Volatile
    private var handle = Native.create()

    /** Called when there may be frames to draw again, after [frame] has said that none are wanted. */
    var onChange: () -> Unit = {}

    private inline fun call(work: (Long) -> Unit) {
        if (handle != 0L) work(handle)
    }

    /** A call that may change the image. */
    private inline fun change(work: (Long) -> Unit) = call {
        work(it)
        onChange()
    }

    /**
     * Draws in no window any more. Its memory is free after [waitForClosed]: the main thread does not
     * wait for a driver that is busy.
     */
    override fun close() {
        val closed = handle
        if (closed == 0L) return
        handle = 0
        Native.surfaceDestroyed(closed)
        closing.removeAll { !it.isAlive }
        closing.add(thread(name = "close-session") { Native.destroy(closed) })
    }

    fun surfaceCreated(surface: Surface) = change { Native.surfaceCreated(it, surface) }

    fun surfaceChanged(width: Int, height: Int, density: Float) =
        change { Native.surfaceChanged(it, width, height, density) }

    fun surfaceDestroyed() = call { Native.surfaceDestroyed(it) }

    private fun obeyDriverCheck(session: Long) =
        Native.setDriverLimits(session, DriverCheck.now?.limits?.joinToString(" ") ?: "")

    /** Takes over the descriptor, and draws as the [DriverCheck] says. Returns a number by which the scene is known once it is shown. */
    fun load(descriptor: Int, name: String, bytes: Long, memory: Long, place: DoubleArray?): Long {
        var number = 0L
        change {
            obeyDriverCheck(it)
            number = Native.load(it, descriptor, name, bytes, memory, place)
        }
        return number
    }

    /** Returns once the present view is on the screen, if a scene is. Not for the main thread. */
    fun drawNow() {
        val session = handle
        if (session == 0L) return
        try {
            Native.drawNow(session)
        } catch (_: IllegalStateException) {
            // closed meanwhile
        }
    }

    fun cancelLoading() = call { Native.cancelLoading(it) }

    /** See [PerformanceHints]; 0 where nothing draws. */
    fun drawingThread() = if (handle != 0L) Native.drawingThread(handle) else 0

    fun frameWork() = if (handle != 0L) Native.frameWork(handle) else 0L

    /** True if more frames are wanted. */
    fun frame(nanoseconds: Long) = handle != 0L && Native.frame(handle, nanoseconds)

    fun touch(phase: Int, changed: Int, ids: IntArray, positions: FloatArray, milliseconds: Long) =
        change { Native.touch(it, phase, changed, ids, positions, milliseconds) }

    /** A quaternion: device to world, as the rotation sensor gives it. */
    fun turn(rotation: FloatArray, screenTurns: Int, nanoseconds: Long) = change {
        Native.turn(
            it, rotation[0], rotation[1], rotation[2], rotation[3], screenTurns, nanoseconds,
        )
    }

    fun set(settings: Settings, gyroscope: Boolean, frameSeconds: Float, memory: Long) = change {
        Native.set(
            it, settings.scale, settings.movingScale, settings.sorter, settings.shDegree, settings.maxSplats,
            gyroscope, settings.hud, frameSeconds, memory, settings.backdrop,
        )
    }

    fun setHeat(status: Int, headroom: Float) = change { Native.setHeat(it, status, headroom) }

    fun flipUp() = change { Native.flipUp(it) }

    fun resetView() = change { Native.resetView(it) }

    fun drift(on: Boolean) = change { Native.drift(it, on) }

    fun goTo(place: DoubleArray) = change { Native.goTo(it, place) }

    /** The path to [play]: through views, as [place] gives them. Returns its seconds; 0 without a session. */
    fun pathThrough(places: List<DoubleArray>, closed: Boolean, seconds: Double) = path {
        Native.pathThrough(it, places.flatMap { place -> place.asList() }.toDoubleArray(), closed, seconds)
    }

    fun pathAround(seconds: Double) = path { Native.pathAround(it, seconds) }

    /** Throws an IllegalArgumentException that says what is wrong with the file. */
    fun pathOf(json: ByteArray) = path { Native.pathOf(it, json) }

    private fun path(make: (Long) -> Double) = if (handle != 0L) make(handle) else 0.0

    fun play(on: Boolean) = change { Native.play(it, on) }

    /** A video of the path, on the surface of an encoder. */
    fun startVideo(surface: Surface, size: Size, fps: Int) =
        call { Native.startVideo(it, surface, size.width, size.height, fps.toDouble()) }

    fun stopVideo(why: String) = call { Native.stopVideo(it, why) }

    fun video(): JSONObject? = if (handle != 0L) JSONObject(Native.video(handle)) else null

    fun walk(on: Boolean) = change { Native.walk(it, on) }

    fun stick(right: Float, ahead: Float) = change { Native.stick(it, right, ahead) }

    /** Of a mouse or a keyboard. */
    fun handle(event: WindowEvent, milliseconds: Long) = change {
        Native.windowEvent(
            it, event.kind, event.x, event.y, event.button, event.down, event.amount, event.key.code, milliseconds,
        )
    }

    fun freeGraphics() = change { Native.freeGraphics(it) }

    fun loseContext() = change { Native.loseContext(it) }

    fun state(): SessionState? = if (handle != 0L) SessionState.of(Native.state(handle)) else null

    fun place(): DoubleArray? = if (handle != 0L) Native.place(handle) else null

    /**
     * Waits for the drawing thread: not for the main one. [longest]: of its sides, 0 for all of it; null
     * where it is not [of] the scene with this number (0: any).
     */
    fun image(longest: Int = 0, of: Long = 0): Bitmap? {
        val session = handle
        if (session == 0L) return null
        val values = try {
            Native.image(session, longest, of)
        } catch (_: IllegalStateException) {
            null // closed meanwhile
        } ?: return null
        return Bitmap.createBitmap(
            values, 2, values[0], values[0], values[1], Bitmap.Config.ARGB_8888,
        )
    }

    /** The self-test of this processor on the scene, or {"error": …}. Takes seconds: not for the main thread. */
    fun selfTest(): JSONObject = try {
        JSONObject(Native.selfTest(handle))
    } catch (problem: Throwable) { // of memory, too: what is measured is not lost for it
        JSONObject().put("error", problem.toString())
    }

    fun driver(): JSONObject? {
        val text = if (handle != 0L) Native.driver(handle) else ""
        return if (text.isEmpty()) null else JSONObject(text)
    }

    fun startBenchmark(plan: BenchmarkPlan) = call {
        obeyDriverCheck(it)
        Native.startBenchmark(
            it, plan.sizes, plan.warmup, plan.frames, plan.gpuSort, plan.cpuSort, plan.slices,
        )
    }

    fun stopBenchmark(why: String) = call { Native.stopBenchmark(it, why) }

    fun benchmark(): JSONObject? = if (handle != 0L) JSONObject(Native.benchmark(handle)) else null

    companion object {
        private val closing = ConcurrentLinkedQueue<Thread>()

        /** Until the memory of all sessions that were closed is free. Not for the main thread. */
        fun waitForClosed() = closing.forEach { it.join() }
    }
}
