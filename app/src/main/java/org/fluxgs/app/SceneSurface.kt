package org.fluxgs.app

import android.content.Context
import android.util.AttributeSet
import android.util.Size
import android.view.Choreographer
import android.view.GestureDetector
import android.view.MotionEvent
import android.view.Surface
import android.view.SurfaceHolder
import android.view.SurfaceView

/**
 * What the session draws on. While it is [running], every frame of the display is handed on, as long as
 * the session wants frames; touches always are. The size is that of the surface, in pixels.
 */
class SceneSurface(context: Context, attributes: AttributeSet?) :
    SurfaceView(context, attributes), SurfaceHolder.Callback, Choreographer.FrameCallback {

    /** May be another one at any time: it gets the surface that is there. */
    var session: Session? = null
        set(value) {
            val surface = drawnOn
            if (field !== value && surface != null) field?.surfaceDestroyed()
            field?.onChange = {}
            field = value
            value?.onChange = ::wake
            if (surface != null) value?.surfaceCreated(surface)
            if (surface != null) tellSize()
            wake()
        }

    /** A tap that is not the first of two. */
    var onTap: (() -> Unit)? = null

    var running = false
        set(value) {
            if (value == field) return
            field = value
            if (value) return wake()
            Choreographer.getInstance().removeFrameCallback(this)
            isAwake = false
        }

    /** True if a frame of the display is waited for. */
    internal var isAwake = false
        private set

    private fun wake() {
        if (!running || isAwake) return
        isAwake = true
        Choreographer.getInstance().postFrameCallback(this)
    }

    private var drawnOn: Surface? = null // while there is one
    private var size = Size(0, 0) // of the surface
    private val taps = GestureDetector(context, object : GestureDetector.SimpleOnGestureListener() {
        override fun onSingleTapConfirmed(event: MotionEvent): Boolean {
            performClick()
            return true
        }
    })

    init {
        holder.addCallback(this)
        isClickable = true
        accessibilityDelegate = SceneActions()
    }

    override fun surfaceCreated(holder: SurfaceHolder) {
        drawnOn = holder.surface
        session?.surfaceCreated(holder.surface)
    }

    override fun surfaceChanged(holder: SurfaceHolder, format: Int, width: Int, height: Int) {
        size = Size(width, height)
        tellSize()
    }

    private fun tellSize() {
        session?.surfaceChanged(size.width, size.height, resources.displayMetrics.density)
    }

    override fun surfaceDestroyed(holder: SurfaceHolder) {
        drawnOn = null
        session?.surfaceDestroyed()
    }

    override fun doFrame(nanoseconds: Long) {
        isAwake = false
        if (session?.frame(nanoseconds) == true) wake()
    }

    override fun performClick(): Boolean {
        super.performClick()
        onTap?.invoke()
        return true
    }

    override fun onTouchEvent(event: MotionEvent): Boolean {
        taps.onTouchEvent(event)
        val phase = when (event.actionMasked) {
            MotionEvent.ACTION_DOWN, MotionEvent.ACTION_POINTER_DOWN -> 0
            MotionEvent.ACTION_MOVE -> 1
            MotionEvent.ACTION_UP, MotionEvent.ACTION_POINTER_UP -> 2
            MotionEvent.ACTION_CANCEL -> 3
            else -> return false
        }
        val count = event.pointerCount
        val ids = IntArray(count) { event.getPointerId(it) }
        val positions = FloatArray(2 * count) {
            if (it % 2 == 0) event.getX(it / 2) else event.getY(it / 2)
        }
        session?.touch(phase, ids[event.actionIndex], ids, positions, event.eventTime)
        return true
    }
}
