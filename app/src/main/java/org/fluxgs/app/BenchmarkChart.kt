package org.fluxgs.app

import android.content.Context
import android.graphics.Canvas
import android.graphics.DashPathEffect
import android.graphics.Paint
import android.util.AttributeSet
import android.util.TypedValue
import android.view.View
import java.text.NumberFormat
import kotlin.math.ceil
import kotlin.math.log10
import kotlin.math.max
import kotlin.math.pow

/**
 * Two bars a row: frames a second when only drawing, and from the sort to the image; a tick where the earlier
 * run was, a line where the paper is, and an axis below.
 */
class BenchmarkChart(context: Context, attributes: AttributeSet?) : View(context, attributes) {
    private var rows = emptyList<BenchmarkRow>()
    private var before = emptyList<BenchmarkRow>()
    private val unit = resources.displayMetrics.density
    private val text = Paint(Paint.ANTI_ALIAS_FLAG)
    private val bar = Paint()
    private val line = Paint().apply { strokeWidth = unit }
    private val dashes = DashPathEffect(floatArrayOf(4 * unit, 4 * unit), 0f)
    private val whole = NumberFormat.getIntegerInstance()
    private val tenths = NumberFormat.getNumberInstance().apply {
        minimumFractionDigits = 1
        maximumFractionDigits = 1
    }

    init {
        text.textSize =
            TypedValue.applyDimension(TypedValue.COMPLEX_UNIT_SP, 12f, resources.displayMetrics)
    }

    internal fun show(rows: List<BenchmarkRow>, before: List<BenchmarkRow>) {
        this.rows = rows
        this.before = before
        contentDescription = rows.joinToString("; ") {
            resources.getString(R.string.chart_row, it.label(context), it.drawFps, it.sortToDisplayFps)
        }
        requestLayout()
        invalidate()
    }

    override fun onMeasure(width: Int, height: Int) {
        val wanted = (rows.size * rowHeight() + axisHeight() + paddingTop + paddingBottom).toInt()
        setMeasuredDimension(MeasureSpec.getSize(width), resolveSize(wanted, height))
    }

    override fun onDraw(canvas: Canvas) {
        val most = (rows + before).maxOfOrNull { max(it.drawFps, it.sortToDisplayFps) } ?: return
        val scale = Scale(max(most, PAPER_FPS * 1.05))
        val bottom = paddingTop + rows.size * rowHeight()
        drawAxis(canvas, scale, bottom)
        rows.forEachIndexed { i, row -> drawRow(canvas, scale, paddingTop + i * rowHeight(), row) }
    }

    /** Beside the bars only, so that what is written above them can be read. */
    private fun drawLine(canvas: Canvas, at: Float, top: Float, color: Int, width: Float, dashes: DashPathEffect?) {
        line.color = context.getColor(color)
        line.strokeWidth = width
        line.pathEffect = dashes
        canvas.drawLine(at, top - 2 * unit, at, top + 33 * unit, line)
    }

    /** From frames a second to places; the numbers stand in a column of their own, right of all bars. */
    private inner class Scale(private val most: Double) {
        private val room = width - paddingLeft - paddingRight - NUMBERS_DP * unit

        fun x(fps: Double) = paddingLeft + (fps / most).toFloat() * room

        /** Round numbers, four to nine of them. */
        fun marks(): List<Double> {
            val tens = 10.0.pow(ceil(log10(most)) - 1)
            val step = listOf(0.2, 0.5, 1.0).map { it * tens }.first { most / it < 6 || it == tens }
            return generateSequence(0.0) { it + step }.takeWhile { it <= most }.toList()
        }
    }

    private fun drawAxis(canvas: Canvas, scale: Scale, bottom: Float) {
        text.color = context.getColor(R.color.dim)
        text.textAlign = Paint.Align.CENTER
        for (mark in scale.marks().drop(1))
            canvas.drawText(whole.format(mark), scale.x(mark), bottom + 6 * unit + text.textSize, text)
        text.textAlign = Paint.Align.LEFT
        canvas.drawText(
            resources.getString(R.string.chart_axis), paddingLeft.toFloat(),
            bottom + 10 * unit + 2 * text.textSize, text,
        )
    }

    private fun drawRow(canvas: Canvas, scale: Scale, top: Float, row: BenchmarkRow) {
        val earlier = before.find { it.isLike(row) }
        text.color = context.getColor(R.color.text)
        canvas.drawText(row.label(context), paddingLeft.toFloat(), top + text.textSize, text)
        val under = top + text.textSize + 5 * unit
        for (mark in scale.marks()) drawLine(canvas, scale.x(mark), under, R.color.outline, unit, null)
        drawBar(canvas, scale, under, row.drawFps, earlier?.drawFps, R.color.bar_draw)
        drawBar(canvas, scale, under + 17 * unit, row.sortToDisplayFps, earlier?.sortToDisplayFps, R.color.bar_sort)
        drawLine(canvas, scale.x(PAPER_FPS), under, R.color.paper, 2 * unit, dashes)
    }

    private fun drawBar(canvas: Canvas, scale: Scale, top: Float, fps: Double, earlier: Double?, color: Int) {
        bar.color = context.getColor(color)
        canvas.drawRect(scale.x(0.0), top, scale.x(fps), top + 14 * unit, bar)
        text.textAlign = Paint.Align.RIGHT
        canvas.drawText(tenths.format(fps), (width - paddingRight).toFloat(), top + 12 * unit, text)
        text.textAlign = Paint.Align.LEFT
        if (earlier == null) return
        bar.color = context.getColor(R.color.text)
        val at = scale.x(earlier)
        canvas.drawRect(at - unit, top - 2 * unit, at + unit, top + 16 * unit, bar)
    }

    private fun rowHeight() = text.textSize + 47 * unit

    private fun axisHeight() = 2 * text.textSize + 14 * unit

    internal companion object {
        /** Of the paper: the mean of its scenes, on a Snapdragon 8 Gen 3, drawn off the screen. */
        const val PAPER_FPS = 139.0
        private const val NUMBERS_DP = 52
    }
}
