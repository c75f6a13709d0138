package org.fluxgs.app

import android.content.Context
import android.graphics.Canvas
import android.graphics.Paint
import android.util.AttributeSet
import android.view.MotionEvent
import android.view.View
import kotlin.math.hypot
import kotlin.math.max
import kotlin.math.min

/** A stick for a thumb: where it points is told while it is held, and that it is in the middle again. */
class ThumbStick(context: Context, attributes: AttributeSet?) : View(context, attributes) {
    /** To the right and ahead, both −1 to 1. */
    var onMove: (right: Float, ahead: Float) -> Unit = { _, _ -> }

    private val paint = Paint(Paint.ANTI_ALIAS_FLAG).apply { color = 0x66FFFFFF }
    private var right = 0f
    private var ahead = 0f

    override fun onDraw(canvas: Canvas) {
        val radius = min(width, height) / 2f
        paint.alpha = 0x33
        canvas.drawCircle(width / 2f, height / 2f, radius, paint)
        paint.alpha = 0x99
        val reach = radius * (1 - KNOB)
        canvas.drawCircle(width / 2f + right * reach, height / 2f - ahead * reach, radius * KNOB, paint)
    }

    override fun onTouchEvent(event: MotionEvent): Boolean {
        when (event.actionMasked) {
            MotionEvent.ACTION_DOWN, MotionEvent.ACTION_MOVE -> point(event.x, event.y)
            MotionEvent.ACTION_UP, MotionEvent.ACTION_CANCEL -> move(0f, 0f)
        }
        return true
    }

    private fun point(x: Float, y: Float) {
        val reach = min(width, height) / 2f * (1 - KNOB)
        if (reach <= 0) return
        val toRight = (x - width / 2f) / reach
        val toAhead = (height / 2f - y) / reach
        val length = max(hypot(toRight, toAhead), 1f)
        move(toRight / length, toAhead / length)
    }

    private fun move(toRight: Float, toAhead: Float) {
        if (toRight == right && toAhead == ahead) return
        right = toRight
        ahead = toAhead
        onMove(right, ahead)
        invalidate()
    }

    override fun onVisibilityChanged(changed: View, visibility: Int) {
        super.onVisibilityChanged(changed, visibility)
        if (visibility != VISIBLE) move(0f, 0f) // it may go under a thumb
    }

    private companion object {
        const val KNOB = 0.4f // of the radius
    }
}
