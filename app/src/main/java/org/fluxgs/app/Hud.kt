package org.fluxgs.app

import android.content.res.Resources
import android.widget.TextView
import java.util.Locale

/** The line of numbers over a scene. */
internal object Hud {
    /** Every text that is set is drawn anew. */
    fun show(view: TextView, stats: Stats, heat: Heat) {
        val text = text(view.resources, stats, heat)
        if (view.text.toString() != text) view.text = text
    }

    private fun text(resources: Resources, stats: Stats, heat: Heat): String {
        val parts = mutableListOf<String>()
        parts += if (stats.fps > 0) resources.getString(R.string.hud_fps, stats.fps)
        else resources.getString(R.string.hud_still)
        parts += Texts.milliseconds(stats.frameMs)
        parts += resources.getString(
            R.string.hud_splats, Texts.count(stats.drawn), Texts.count(stats.splats),
        )
        parts += resources.getString(R.string.hud_sort, Texts.milliseconds(stats.sortMs))
        if (stats.scale < 1) parts += String.format(Locale.getDefault(), "%.0f%%", 100 * stats.scale)
        if (!heat.headroom.isNaN()) parts += resources.getString(R.string.hud_heat, heat.headroom)
        if (stats.reduced) parts += resources.getString(R.string.hud_memory)
        if (stats.shown < stats.splats)
            parts += resources.getString(R.string.hud_best, Texts.count(stats.shown))
        if (stats.image < 1)
            parts += resources.getString(R.string.hud_coarse, 100 * stats.image)
        return parts.joinToString("  ·  ")
    }
}
