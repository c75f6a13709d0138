package org.fluxgs.app

import android.content.res.Resources
import android.view.View
import android.widget.TextView
import java.util.Locale

/** The line over a scene: numbers for who asks for them, and for everybody what is missing in the image. */
internal object Hud {
    /** Every text that is set is drawn anew. */
    fun show(view: TextView, stats: Stats, heat: Heat, numbers: Boolean) {
        val resources = view.resources
        val parts = (if (numbers) numbers(resources, stats, heat) else emptyList()) + losses(resources, stats)
        val text = parts.joinToString("  ·  ")
        view.visibility = if (parts.isEmpty()) View.GONE else View.VISIBLE
        if (view.text.toString() != text) view.text = text
    }

    private fun numbers(resources: Resources, stats: Stats, heat: Heat): List<String> {
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
        return parts
    }

    private fun losses(resources: Resources, stats: Stats): List<String> {
        val parts = mutableListOf<String>()
        if (stats.reduced) parts += resources.getString(R.string.hud_memory)
        if (stats.shown < stats.splats)
            parts += resources.getString(R.string.hud_best, Texts.millions(stats.shown), Texts.millions(stats.splats))
        if (stats.shDegree < stats.fileShDegree)
            parts += resources.getString(R.string.hud_degree, stats.shDegree, stats.fileShDegree)
        if (stats.image < 1)
            parts += resources.getString(R.string.hud_coarse, 100 * stats.image)
        return parts
    }
}
