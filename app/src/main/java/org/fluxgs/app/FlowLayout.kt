package org.fluxgs.app

import android.content.Context
import android.util.AttributeSet
import android.view.View
import android.view.ViewGroup

/** Views in lines, as words in a text: what has no room in one comes into the next. */
class FlowLayout(context: Context, attributes: AttributeSet?) : ViewGroup(context, attributes) {
    override fun onMeasure(width: Int, height: Int) {
        measureChildren(width, MeasureSpec.makeMeasureSpec(0, MeasureSpec.UNSPECIFIED))
        val lines = lines(MeasureSpec.getSize(width))
        setMeasuredDimension(
            resolveSize(lines.maxOfOrNull { line -> line.sumOf { it.measuredWidth } } ?: 0, width),
            resolveSize(lines.sumOf { heightOf(it) }, height),
        )
    }

    override fun onLayout(changed: Boolean, left: Int, top: Int, right: Int, bottom: Int) {
        val backwards = layoutDirection == LAYOUT_DIRECTION_RTL
        var y = 0
        for (line in lines(width)) {
            var x = 0
            for (view in line) {
                val start = if (backwards) width - x - view.measuredWidth else x
                view.layout(start, y, start + view.measuredWidth, y + view.measuredHeight)
                x += view.measuredWidth
            }
            y += heightOf(line)
        }
    }

    private fun heightOf(line: List<View>) = line.maxOf { it.measuredHeight }

    private fun lines(room: Int): List<List<View>> {
        val lines = mutableListOf<MutableList<View>>()
        var used = 0
        for (view in (0 until childCount).map { getChildAt(it) }.filter { it.visibility != GONE }) {
            if (lines.isEmpty() || used + view.measuredWidth > room) {
                lines += mutableListOf<View>()
                used = 0
            }
            lines.last() += view
            used += view.measuredWidth
        }
        return lines
    }
}
