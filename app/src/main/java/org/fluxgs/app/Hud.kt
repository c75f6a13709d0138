package org.fluxgs.app

import android.content.res.Resources
import android.view.View
import android.widget.TextView
import java.text.NumberFormat
import kotlin.math.roundToLong

/** The lines over a scene: numbers for who asks for them, and for everybody what is missing in the image. */
internal object Hud {
    /** Every text that is set is drawn anew. */
    fun show(view: TextView, stats: Stats, numbers: Boolean) {
        val resources = view.resources
        val lines = listOfNotNull(if (numbers) numbers(resources, stats) else null, loss(resources, stats))
        val text = lines.joinToString("\n")
        view.visibility = if (lines.isEmpty()) View.GONE else View.VISIBLE
        if (view.text.toString() != text) view.text = text
    }

    private fun numbers(resources: Resources, stats: Stats): String = listOf(
        if (stats.fps > 0) resources.getString(R.string.hud_fps, Texts.count(stats.fps.roundToLong()))
        else resources.getString(R.string.hud_still),
        resources.getString(R.string.hud_splats, Texts.short(stats.drawn), Texts.short(stats.splats)),
        resources.getString(
            R.string.hud_sharpness, NumberFormat.getPercentInstance().format(stats.scale * stats.image),
        ),
    ).joinToString(" · ")

    private fun loss(resources: Resources, stats: Stats): String? = listOfNotNull(
        when {
            stats.reduced || stats.image < 1 -> resources.getString(R.string.reduced_memory)
            stats.coolest < 1 -> resources.getString(R.string.reduced_heat)
            else -> null
        },
        if (stats.shown >= stats.splats) null
        else resources.getString(R.string.hud_splats, Texts.millions(stats.shown), Texts.millions(stats.splats)),
        if (stats.shDegree >= stats.fileShDegree) null
        else resources.getString(R.string.hud_degree, stats.shDegree, stats.fileShDegree),
    ).joinToString(" · ").ifEmpty { null }
}
