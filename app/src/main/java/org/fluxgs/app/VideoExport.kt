package org.fluxgs.app

import android.content.Context
import android.net.Uri
import android.os.Environment
import android.os.Handler
import android.os.Looper
import android.os.StatFs
import android.os.SystemClock
import android.util.Size
import java.io.IOException
import kotlin.concurrent.thread

/**
 * Makes a video of the path that the session was given, and puts it into the gallery. For the main thread.
 * [onEnd] has the video, or why there is none; neither where [cancel] was called, and then nothing is left.
 */
internal class VideoExport(
    private val context: Context,
    private val session: Session,
    private val scene: String,
    private val size: Size,
    private val fps: Int,
    private val seconds: Double,
    private val onProgress: (done: Int, all: Int, secondsLeft: Long?) -> Unit,
    private val onEnd: (video: Uri?, problem: String?) -> Unit,
) {
    private val main = Handler(Looper.getMainLooper())
    private var file: VideoFile? = null
    private var encoder: VideoEncoder? = null
    private var began = 0L
    @Volatile
    private var stopped: String? = null // why; empty: by whoever wanted the video

    fun start() = apart {
        if (freeBytes() < CodecEncoder.bitsPerSecond(size, fps) / 8 * seconds + SPARE_BYTES)
            throw IOException(context.getString(R.string.video_no_room))
        val made = VideoFile.create(context, scene)
        file = made
        encoder = VideoEncoder.open(made.descriptor.fileDescriptor, size, fps) { main.post { stop(FAILED) } }
        main.post(::film)
    }

    fun cancel() = stop("")

    /** As [cancel], but it is told [why]. */
    fun stop(why: String) {
        if (stopped != null) return
        stopped = why
        session.stopVideo(why)
    }

    private fun film() {
        if (stopped != null) return end()
        try {
            session.startVideo(encoder!!.surface, size, fps)
        } catch (problem: RuntimeException) { // of a session that is closed
            return end(problem.message)
        }
        began = SystemClock.elapsedRealtime()
        look()
    }

    private fun look() {
        val state = session.video() ?: return end(context.getString(R.string.stopped_by_leaving))
        val done = state.getInt("done")
        if (!state.getBoolean("running")) return end(state.getString("error").ifEmpty { null })
        onProgress(done, state.getInt("all"), secondsLeft(SystemClock.elapsedRealtime() - began, done, state.getInt("all")))
        main.postDelayed(::look, LOOK_EVERY_MS)
    }

    private fun end(problem: String? = null) = apart {
        val why = stopped?.takeIf { it != FAILED } ?: problem
        if (why != null) return@apart close(null, why)
        encoder!!.finish() // says what has failed
        close(file!!.publish(), null)
    }

    /** Whatever happens on the way, nothing is left of a video that is not whole. */
    private fun apart(work: () -> Unit) {
        thread(name = "video", isDaemon = true) {
            try {
                work()
            } catch (problem: Exception) { // of the disk, the gallery and the encoder
                val full = freeBytes() < SPARE_BYTES
                close(null, if (full) context.getString(R.string.video_no_room) else problem.message ?: problem.toString())
            }
        }
    }

    private fun close(video: Uri?, problem: String?) {
        encoder?.close()
        if (video == null) file?.discard()
        main.post { onEnd(video, problem?.ifEmpty { null }) }
    }

    private fun freeBytes() = try {
        StatFs(Environment.getExternalStorageDirectory().path).availableBytes
    } catch (_: IllegalArgumentException) { // it is not there
        0L
    }

    companion object {
        private const val LOOK_EVERY_MS = 200L
        private const val SPARE_BYTES = 20_000_000L
        private const val FAILED = "the encoder has failed"

        /** By the mean time of the frames so far; null while there are too few. */
        fun secondsLeft(elapsedMs: Long, done: Int, all: Int): Long? =
            if (done < 5 || elapsedMs < 1000) null else elapsedMs * (all - done) / done / 1000
    }
}
