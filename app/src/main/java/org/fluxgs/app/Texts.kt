package org.fluxgs.app

import android.content.Context
import android.icu.text.CompactDecimalFormat
import android.text.format.DateUtils
import android.text.format.Formatter
import java.text.NumberFormat
import java.util.Locale

/** Numbers and names as people read them. */
internal object Texts {
    val SCENE_ENDINGS = setOf("glb", "ply", "spz", "splat", "sog")
    private const val LONGEST_NAME = 60

    fun size(context: Context, bytes: Long): String = Formatter.formatShortFileSize(context, bytes)

    fun count(value: Long): String = NumberFormat.getIntegerInstance().format(value)

    /** "123K"; before Android 9 "120K". */
    fun short(value: Long): String = CompactDecimalFormat
        .getInstance(Locale.getDefault(), CompactDecimalFormat.CompactStyle.SHORT).format(value)

    /** Large ones in short: "1.9 M". */
    fun millions(value: Long): String =
        if (value < 100_000) count(value) else String.format(Locale.getDefault(), "%.1f M", value / 1e6)

    fun milliseconds(value: Double): String = String.format(Locale.getDefault(), "%.1f ms", value)

    fun splats(context: Context, value: Long, number: (Long) -> String = ::count): String =
        context.resources.getQuantityString(
            R.plurals.splats, value.coerceAtMost(Int.MAX_VALUE.toLong()).toInt(), number(value),
        )

    /** "yesterday" */
    fun day(time: Long): String = DateUtils.getRelativeTimeSpanString(
        time, System.currentTimeMillis(), DateUtils.DAY_IN_MILLIS,
    ).toString().replaceFirstChar { it.lowercase() }

    /** "about 30 s left" */
    fun left(context: Context, seconds: Long): String =
        if (seconds < 90) context.getString(R.string.seconds_left, seconds)
        else context.getString(R.string.minutes_left, (seconds + 30) / 60)

    /** The name of a scene without its ending. */
    fun titleOf(name: String): String = name.removeSuffix(endingOf(name)).ifEmpty { name }

    /** With its dot; empty where the name ends like no scene. */
    fun endingOf(name: String): String {
        val ending = name.substringAfterLast('.', "")
        return if (ending.lowercase() in SCENE_ENDINGS) ".$ending" else ""
    }

    /** A scene's name comes from another app: as a file's name it may lead anywhere. */
    fun plain(name: String): String =
        name.replace(Regex("[^\\p{L}\\p{N} ._-]+"), "-").trim(' ', '.', '-').take(LONGEST_NAME).ifEmpty { "scene" }
}
