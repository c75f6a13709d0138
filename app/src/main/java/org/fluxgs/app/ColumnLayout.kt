package org.fluxgs.app

import android.content.Context
import android.util.AttributeSet
import android.widget.LinearLayout

/** No wider than android:maxWidth: what is read is not stretched over a tablet. */
class ColumnLayout(context: Context, attributes: AttributeSet?) : LinearLayout(context, attributes) {
    private val most = context.obtainStyledAttributes(attributes, intArrayOf(android.R.attr.maxWidth)).let { values ->
        values.getDimensionPixelSize(0, Int.MAX_VALUE).also { values.recycle() }
    }

    override fun onMeasure(width: Int, height: Int) {
        val room = MeasureSpec.getSize(width)
        val wide = room > most && MeasureSpec.getMode(width) != MeasureSpec.UNSPECIFIED
        super.onMeasure(if (wide) MeasureSpec.makeMeasureSpec(most, MeasureSpec.getMode(width)) else width, height)
    }
}
