package org.fluxgs.app

import android.annotation.TargetApi
import android.content.Context
import android.os.Build
import android.os.PerformanceHintManager

/** What a system does with hints: [PerformanceHintManager.Session], or a test. */
internal interface HintSession {
    fun report(nanoseconds: Long)
    fun target(nanoseconds: Long)
    fun close()
}

/**
 * Tells the system how long the drawing thread works for a frame, and how long it may, while frames are
 * drawn: so that it is given a processor that is fast enough, and no faster. From Android 12 on, where the device
 * listens.
 */
internal class PerformanceHints(private val context: Context) {
    private var open: HintSession? = null
    private var thread = 0 // that it is open for
    private var target = 0L

    /** After a frame of a [session] that aims at [goal] frames a second. */
    fun frame(session: Session, goal: Float) {
        val drawing = session.drawingThread()
        val work = session.frameWork()
        if (drawing == 0 || work <= 0) return
        val wanted = (1e9 / if (goal > 0) goal else USUAL).toLong()
        if (drawing != thread) {
            rest()
            open = opener(context, drawing, wanted)
            thread = drawing
            target = wanted
        }
        if (wanted != target) open?.target(wanted)
        target = wanted
        open?.report(work)
    }

    /** No frame is drawn for now. */
    fun rest() {
        open?.close()
        open = null
        thread = 0
    }

    companion object {
        private const val USUAL = 60f

        /** Context, number of a thread, nanoseconds of a frame; null where the device does not listen. */
        internal var opener: (Context, Int, Long) -> HintSession? = { context, thread, target ->
            if (Build.VERSION.SDK_INT >= 31) systemSession(context, thread, target) else null
        }

        @TargetApi(31)
        private fun systemSession(context: Context, thread: Int, target: Long): HintSession? =
            context.getSystemService(PerformanceHintManager::class.java)
                ?.createHintSession(intArrayOf(thread), target)?.let { SystemSession(it) }
    }

    @TargetApi(31)
    private class SystemSession(private val session: PerformanceHintManager.Session) : HintSession {
        override fun report(nanoseconds: Long) = session.reportActualWorkDuration(nanoseconds)
        override fun target(nanoseconds: Long) = session.updateTargetWorkDuration(nanoseconds)
        override fun close() = session.close()
    }
}
