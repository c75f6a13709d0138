package org.fluxgs.app

import android.view.Surface

/**
 * The native library (app/src/main/cpp/platform/android/jni.cpp). Sessions are numbers from [create];
 * one that does not exist is an IllegalStateException. Nothing here waits, but [waitForHeldScenes], and for
 * the drawing thread [drawNow], [image], [selfTest] and [destroy]. [Session] is what the app
 * uses.
 */
internal object Native {
    init {
        System.loadLibrary("fluxgs_app")
    }

    @JvmStatic external fun create(): Long

    @JvmStatic external fun destroy(session: Long)

    @JvmStatic external fun surfaceCreated(session: Long, surface: Surface)

    /** [density]: pixels of a dp. */
    @JvmStatic external fun surfaceChanged(session: Long, width: Int, height: Int, density: Float)

    /** Returns when nothing is drawn on the surface any more, after a frame at most. */
    @JvmStatic external fun surfaceDestroyed(session: Long)

    /**
     * Takes over the descriptor, of which somebody says that it has so many [bytes] (-1: nobody does).
     * [place] has 12 numbers, see [place]. Returns the loading's number, from 1 on.
     */
    @JvmStatic external fun load(
        session: Long, descriptor: Int, name: String, bytes: Long, memory: Long, place: DoubleArray?,
    ): Long

    /** One that is being decoded is decoded to its end all the same, and holds its memory till then. */
    @JvmStatic external fun cancelLoading(session: Long)

    /**
     * Returns once nothing is being decoded or tested, of any session, cancelled or closed: what is free
     * then is free for another scene. Not for the main thread.
     */
    @JvmStatic external fun waitForHeldScenes()

    /** True if more frames are wanted: false once all is at rest, until something else is called. */
    @JvmStatic external fun frame(session: Long, nanoseconds: Long): Boolean

    /** The system's number of the thread that draws; 0 before it runs. */
    @JvmStatic external fun drawingThread(session: Long): Int

    /** Nanoseconds of a processor that it took for the last frame. */
    @JvmStatic external fun frameWork(session: Long): Long

    /** Draws a frame of the scene that is shown, if one is, and waits until it is on its way. From any thread. */
    @JvmStatic external fun drawNow(session: Long)

    /** [positions]: x and y of each finger. [phase]: 0 down, 1 moved, 2 up, 3 cancelled. */
    @JvmStatic external fun touch(
        session: Long, phase: Int, changed: Int, ids: IntArray, positions: FloatArray,
        milliseconds: Long,
    )

    @JvmStatic external fun turn(
        session: Long, x: Float, y: Float, z: Float, w: Float, screenTurns: Int, nanoseconds: Long,
    )

    /** [scale]: 0, or 0.2 to 1; [movingScale], the most while something moves where that is 0: 0.2 to 1. */
    @JvmStatic external fun set(
        session: Long, scale: Float, movingScale: Float, sorter: Int, shDegree: Int, maxSplats: Int,
        gyroscope: Boolean, measures: Boolean, frameSeconds: Float, memory: Long, background: Int,
    )

    /** Names of what to do without (render/driver_limits.h), in any order. */
    @JvmStatic external fun setDriverLimits(session: Long, names: String)

    /**
     * Draws a scene and compares: JSON, see driver_check.h, or an empty text if the driver is the [known]
     * one, "renderer, version". Takes up to seconds. From any thread; a RuntimeException where there is no
     * OpenGL ES 3.1.
     */
    @JvmStatic external fun checkDriver(scene: ByteArray, golden: ByteArray, known: String): String

    @JvmStatic external fun setHeat(session: Long, status: Int, headroom: Float)

    @JvmStatic external fun flipUp(session: Long)

    @JvmStatic external fun resetView(session: Long)

    /** Turns slowly round what is looked at until the next touch, or no longer. */
    @JvmStatic external fun drift(session: Long, on: Boolean)

    /** Smoothly to a [place]. */
    @JvmStatic external fun goTo(session: Long, place: DoubleArray)

    /**
     * The path that [play] plays: through [places], 12 numbers each, one after the other. Returns the seconds
     * of once through, as the two below.
     */
    @JvmStatic external fun pathThrough(session: Long, places: DoubleArray, closed: Boolean, seconds: Double): Double

    /** Once round what is looked at. */
    @JvmStatic external fun pathAround(session: Long, seconds: Double): Double

    /** SuperSplat's settings.json; an IllegalArgumentException that says in one line what is wrong with it. */
    @JvmStatic external fun pathOf(session: Long, json: ByteArray): Double

    @JvmStatic external fun play(session: Long, on: Boolean)

    /** A video of the path, on the surface of an encoder. */
    @JvmStatic external fun startVideo(session: Long, surface: Surface, width: Int, height: Int, fps: Double)

    @JvmStatic external fun stopVideo(session: Long, why: String)

    /** JSON, see session_json.h. */
    @JvmStatic external fun video(session: Long): String

    @JvmStatic external fun walk(session: Long, on: Boolean)

    /** While people walk: where to, −1 to 1. */
    @JvmStatic external fun stick(session: Long, right: Float, ahead: Float)

    /** Of a mouse or a keyboard; kinds, buttons and keys are those of viewer/window_event.h. */
    @JvmStatic external fun windowEvent(
        session: Long, kind: Int, x: Float, y: Float, button: Int, down: Boolean, amount: Float,
        key: Int, milliseconds: Long,
    )

    /** Frees the GL objects; the next frame makes them again. */
    @JvmStatic external fun freeGraphics(session: Long)

    @JvmStatic external fun loseContext(session: Long)

    /** JSON, see session_json.h. */
    @JvmStatic external fun state(session: Long): String

    @JvmStatic external fun place(session: Long): DoubleArray?

    /**
     * Width, height, then the colours of the pixels: as large as the window, or the longer side of so
     * many pixels. Of the scene with this number (0: any), or null. From any thread.
     */
    @JvmStatic external fun image(session: Long, longest: Int, of: Long): IntArray?

    /** JSON, of what the driver says of itself; empty before there is a context. */
    @JvmStatic external fun driver(session: Long): String

    @JvmStatic external fun startBenchmark(
        session: Long, sizes: IntArray, warmup: Int, frames: Int, gpuSort: Boolean,
        cpuSort: Boolean, slices: Int,
    )

    @JvmStatic external fun stopBenchmark(session: Long, why: String)

    /** JSON, see session_json.h. */
    @JvmStatic external fun benchmark(session: Long): String

    /** JSON, see self_test.h: of the scene that is loaded. Takes seconds; from any thread. */
    @JvmStatic external fun selfTest(session: Long): String

    /** JSON: version, platform ("android" or "host"), build ("release", "check" or "host"). */
    @JvmStatic external fun about(): String
}
