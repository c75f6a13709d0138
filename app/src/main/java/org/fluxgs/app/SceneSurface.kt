package org.fluxgs.app

import android.annotation.TargetApi
import android.content.Context
import android.graphics.Rect
import android.os.Build
import android.os.SystemClock
import android.util.AttributeSet
import android.util.Size
import android.view.Choreographer
import android.view.GestureDetector
import android.view.KeyEvent
import android.view.MotionEvent
import android.view.Surface
import android.view.SurfaceHolder
import android.view.SurfaceView
import kotlin.concurrent.thread
import kotlin.math.min
import kotlin.math.roundToInt

/**
 * What the session draws on. While it is [running], every frame of the display is handed on, as long as
 * the session wants frames; touches always are. The surface has at most [MOST_PIXELS] across.
 */
class SceneSurface(context: Context, attributes: AttributeSet?) :
    SurfaceView(context, attributes), SurfaceHolder.Callback2, Choreographer.FrameCallback {

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
            hints.rest()
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
        askForGoal()
    }

    override fun surfaceChanged(holder: SurfaceHolder, format: Int, width: Int, height: Int) {
        size = Size(width, height)
        tellSize()
    }

    private fun tellSize() {
        session?.surfaceChanged(size.width, size.height, resources.displayMetrics.density * ratio)
    }

    /** The system shows the window after a turn of the device, say, once there is an image of its new size. */
    override fun surfaceRedrawNeededAsync(holder: SurfaceHolder, drawn: Runnable) {
        val session = session ?: return drawn.run()
        thread(name = "redraw", isDaemon = true) {
            session.drawNow()
            drawn.run()
        }
    }

    override fun surfaceRedrawNeeded(holder: SurfaceHolder) = Unit // of before Android 8

    override fun surfaceDestroyed(holder: SurfaceHolder) {
        drawnOn = null
        session?.surfaceDestroyed()
    }

    /** Frames a second to be drawn, of a display that may have more; 0: as many as it has. */
    var goal = 0f
        set(value) {
            if (value == field) return
            field = value
            askForGoal()
        }

    private fun askForGoal() {
        val surface = drawnOn ?: return
        if (Build.VERSION.SDK_INT >= 30 && surface.isValid) askForGoal(surface)
    }

    @TargetApi(30)
    private fun askForGoal(surface: Surface) =
        surface.setFrameRate(goal, Surface.FRAME_RATE_COMPATIBILITY_DEFAULT)

    private var lastFrame = 0L
    private val hints = PerformanceHints(context)

    override fun doFrame(nanoseconds: Long) {
        isAwake = false
        // The display may go on faster than it was asked to
        if (goal > 0 && nanoseconds - lastFrame < EARLY * 1e9 / goal) return wake()
        lastFrame = nanoseconds
        val drawing = session?.takeIf { it.frame(nanoseconds) } ?: return hints.rest()
        hints.frame(drawing, goal) // of the frame before
        wake()
    }

    /** A finger that begins at the edge orbits; without this the system goes back. */
    override fun onLayout(changed: Boolean, left: Int, top: Int, right: Int, bottom: Int) {
        super.onLayout(changed, left, top, right, bottom)
        if (Build.VERSION.SDK_INT >= 29) keepEdges()
    }

    @TargetApi(29)
    private fun keepEdges() {
        systemGestureExclusionRects = listOf(Rect(0, 0, width, height))
    }

    /** The display's own scaler enlarges what is drawn for it: for nothing, and hardly to be seen. */
    override fun onSizeChanged(width: Int, height: Int, oldWidth: Int, oldHeight: Int) {
        super.onSizeChanged(width, height, oldWidth, oldHeight)
        ratio = min(1f, MOST_PIXELS / min(width, height).coerceAtLeast(1).toFloat())
        if (ratio == 1f) holder.setSizeFromLayout()
        else holder.setFixedSize((width * ratio).roundToInt(), (height * ratio).roundToInt())
    }

    /** Pixels of the surface in one of the view. */
    internal var ratio = 1f
        private set

    override fun performClick(): Boolean {
        super.performClick()
        onTap?.invoke()
        return true
    }

    private var pressed = 0 // button of a mouse

    private fun mouse(event: MotionEvent): Boolean {
        if (event.actionMasked == MotionEvent.ACTION_DOWN) pressed = WindowEvent.buttonOf(event)
        val told = WindowEvent.of(event, ratio, pressed) ?: return false
        session?.handle(told, event.eventTime)
        return true
    }

    override fun onGenericMotionEvent(event: MotionEvent): Boolean =
        event.actionMasked == MotionEvent.ACTION_SCROLL && mouse(event) || super.onGenericMotionEvent(event)

    /** A key of a keyboard; true if it means something here. */
    fun key(event: KeyEvent): Boolean {
        val told = WindowEvent.of(event)
        told.forEach { session?.handle(it, event.eventTime) }
        return told.isNotEmpty()
    }

    override fun onWindowFocusChanged(focused: Boolean) {
        super.onWindowFocusChanged(focused)
        if (!focused) session?.handle(WindowEvent.focusLost, SystemClock.uptimeMillis())
    }

    override fun onTouchEvent(event: MotionEvent): Boolean {
        taps.onTouchEvent(event)
        if (WindowEvent.isOfMouse(event)) return mouse(event)
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
            ratio * if (it % 2 == 0) event.getX(it / 2) else event.getY(it / 2)
        }
        session?.touch(phase, ids[event.actionIndex], ids, positions, event.eventTime)
        return true
    }

    private companion object {
        const val MOST_PIXELS = 1080 // of the shorter side
        const val EARLY = 0.7 // of a frame's time: less is a frame too many
    }
}
