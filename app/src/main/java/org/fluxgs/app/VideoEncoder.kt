package org.fluxgs.app

import android.media.MediaCodec
import android.media.MediaCodecInfo
import android.media.MediaFormat
import android.media.MediaMuxer
import android.os.Handler
import android.os.HandlerThread
import android.util.Size
import android.view.Surface
import java.io.FileDescriptor
import java.io.IOException
import java.util.concurrent.CountDownLatch
import java.util.concurrent.TimeUnit
import kotlin.math.min

/** Makes a video file of what is drawn on its [surface], each frame with its time. */
internal interface VideoEncoder : AutoCloseable {
    val surface: Surface

    /** After the last frame: returns once the file is whole. Not for the main thread. */
    @Throws(IOException::class)
    fun finish()

    /** Without [finish] before, what is in the file is of no use. */
    override fun close()

    companion object {
        /** The largest size up to 1920×1080, or upright, that this device encodes. */
        var sizeFor: (upright: Boolean) -> Size = CodecEncoder::sizeFor

        /** Writes to a file that stays open; tells of a problem, from any thread, as soon as there is one. */
        var open: (FileDescriptor, Size, fps: Int, onProblem: () -> Unit) -> VideoEncoder = ::CodecEncoder
    }
}

/** H.264 in MP4. */
internal class CodecEncoder(
    file: FileDescriptor, size: Size, fps: Int, private val onProblem: () -> Unit,
) : VideoEncoder {
    private val muxer = MediaMuxer(file, MediaMuxer.OutputFormat.MUXER_OUTPUT_MPEG_4)
    private val thread = HandlerThread("encoder").apply { start() }
    private val codec = MediaCodec.createEncoderByType(TYPE)
    private val ended = CountDownLatch(1)
    private var track = -1

    @Volatile
    private var problem: Exception? = null
    private var input: Surface? = null
    override val surface get() = input!!

    init {
        try {
            codec.setCallback(Output(), Handler(thread.looper))
            codec.configure(formatOf(size, fps), null, null, MediaCodec.CONFIGURE_FLAG_ENCODE)
            input = codec.createInputSurface()
            codec.start()
        } catch (problem: RuntimeException) {
            close()
            throw IOException(problem.message ?: problem.toString(), problem)
        }
    }

    private fun formatOf(size: Size, fps: Int) = MediaFormat.createVideoFormat(TYPE, size.width, size.height).apply {
        setInteger(MediaFormat.KEY_COLOR_FORMAT, MediaCodecInfo.CodecCapabilities.COLOR_FormatSurface)
        setInteger(MediaFormat.KEY_BIT_RATE, bitsPerSecond(size, fps))
        setInteger(MediaFormat.KEY_FRAME_RATE, fps)
        setInteger(MediaFormat.KEY_I_FRAME_INTERVAL, 1)
    }

    private inner class Output : MediaCodec.Callback() {
        override fun onInputBufferAvailable(codec: MediaCodec, index: Int) = Unit // it has a surface

        override fun onOutputFormatChanged(codec: MediaCodec, format: MediaFormat) = orFail {
            track = muxer.addTrack(format)
            muxer.start()
        }

        override fun onOutputBufferAvailable(codec: MediaCodec, index: Int, info: MediaCodec.BufferInfo) = orFail {
            val isFrame = info.size > 0 && info.flags and MediaCodec.BUFFER_FLAG_CODEC_CONFIG == 0
            if (isFrame && problem == null) muxer.writeSampleData(track, codec.getOutputBuffer(index)!!, info)
            codec.releaseOutputBuffer(index, false)
            if (info.flags and MediaCodec.BUFFER_FLAG_END_OF_STREAM != 0) ended.countDown()
        }

        override fun onError(codec: MediaCodec, error: MediaCodec.CodecException) = fail(error)
    }

    private inline fun orFail(work: () -> Unit) = try {
        work()
    } catch (problem: RuntimeException) { // of a full disk, too
        fail(problem)
    }

    private fun fail(cause: Exception) {
        if (problem == null) problem = cause
        ended.countDown()
        Handler(thread.looper).post { codec.release() } // whoever waits for it to take a frame waits no longer
        onProblem()
    }

    override fun finish() {
        try {
            problem?.let { throw it }
            codec.signalEndOfInputStream()
            if (!ended.await(LONGEST_END_S, TimeUnit.SECONDS)) throw IOException("the encoder does not end")
            problem?.let { throw it }
            muxer.stop()
        } catch (problem: RuntimeException) {
            throw IOException(problem.message ?: problem.toString(), problem)
        }
    }

    override fun close() {
        codec.release()
        input?.release()
        muxer.release()
        thread.quitSafely()
    }

    companion object {
        private const val TYPE = MediaFormat.MIMETYPE_VIDEO_AVC
        private const val LONGEST_END_S = 30L
        private val HEIGHTS = intArrayOf(1080, 720, 480)

        fun bitsPerSecond(size: Size, fps: Int) = min(size.width * size.height / 5 * fps, 24_000_000)

        fun sizeFor(upright: Boolean): Size {
            val codec = MediaCodec.createEncoderByType(TYPE)
            try {
                val can = codec.codecInfo.getCapabilitiesForType(TYPE).videoCapabilities
                val sizes = HEIGHTS.map { Size(it * 16 / 9 / 2 * 2, it) }
                    .map { if (upright) Size(it.height, it.width) else it }
                return sizes.find { can == null || can.isSizeSupported(it.width, it.height) } ?: sizes.last()
            } finally {
                codec.release()
            }
        }
    }
}
