package org.fluxgs.app

import android.content.Context
import android.graphics.Canvas
import android.graphics.Paint
import android.util.AttributeSet
import android.util.TypedValue
import android.view.View
import java.util.Locale
import kotlin.math.max

/**
 * Two bars a row: frames a second when only drawing, and from the sort to the display; a tick where the
 * earlier run was.
 */
class BenchmarkChart(context: Context, attributes: AttributeSet?) : View(context, attributes) {
    private var rows = emptyList<BenchmarkRow>()
    private var before = emptyList<BenchmarkRow>()
    private val unit = resources.displayMetrics.density
    private val text = Paint(Paint.ANTI_ALIAS_FLAG)
    private val bar = Paint()

    init {
        text.textSize =
            TypedValue.applyDimension(TypedValue.COMPLEX_UNIT_SP, 12f, resources.displayMetrics)
        text.color = context.getColor(R.color.text)
    }

    fun show(rows: List<BenchmarkRow>, before: List<BenchmarkRow>) {
        this.rows = rows
        this.before = before
        contentDescription = rows.joinToString("; ") {
            resources.getString(
                R.string.chart_row, it.label, it.drawFps, fpsOf(it.sortToDisplayMs),
            )
        }
        requestLayout()
        invalidate()
    }

    override fun onMeasure(width: Int, height: Int) {
        val wanted = (rows.size * rowHeight() + paddingTop + paddingBottom).toInt()
        setMeasuredDimension(MeasureSpec.getSize(width), resolveSize(wanted, height))
    }

    override fun onDraw(canvas: Canvas) {
        var top = paddingTop.toFloat()
        val fastest = (rows + before).maxOfOrNull { max(it.drawFps, fpsOf(it.sortToDisplayMs)) } ?: return
        for (row in rows) {
            val earlier = before.find { it.label == row.label }
            canvas.drawText(row.label, paddingLeft.toFloat(), top + text.textSize, text)
            val under = top + text.textSize + 5 * unit
            drawBar(canvas, under, row.drawFps, earlier?.drawFps, fastest, R.color.bar_draw)
            drawBar(
                canvas, under + 17 * unit, fpsOf(row.sortToDisplayMs),
                earlier?.let { fpsOf(it.sortToDisplayMs) }, fastest, R.color.bar_sort,
            )
            top += rowHeight()
        }
    }

    private fun drawBar(
        canvas: Canvas, top: Float, fps: Double, earlier: Double?, fastest: Double, color: Int,
    ) {
        val room = width - paddingLeft - paddingRight - 64 * unit
        val scale = if (fastest > 0) room / fastest.toFloat() else 0f
        val left = paddingLeft.toFloat()
        bar.color = context.getColor(color)
        canvas.drawRect(left, top, left + fps.toFloat() * scale, top + 14 * unit, bar)
        val label = String.format(Locale.getDefault(), "%.1f fps", fps)
        val end = left + max(fps, earlier ?: 0.0).toFloat() * scale
        canvas.drawText(label, end + 6 * unit, top + 12 * unit, text)
        if (earlier == null) return
        bar.color = context.getColor(R.color.text)
        val at = left + earlier.toFloat() * scale
        canvas.drawRect(at - unit, top - 2 * unit, at + unit, top + 16 * unit, bar)
    }

    private fun rowHeight() = text.textSize + 47 * unit

    private fun fpsOf(ms: Double) = if (ms > 0) 1000 / ms else 0.0
}
