package org.fluxgs.app

import java.util.Locale

/** Numbers as people read them. */
internal object Texts {
    fun megabytes(bytes: Long): String = when {
        bytes < 1_000_000 -> String.format(Locale.getDefault(), "%d kB", (bytes + 500) / 1000)
        bytes < 100_000_000 -> String.format(Locale.getDefault(), "%.1f MB", bytes / 1e6)
        else -> String.format(Locale.getDefault(), "%.0f MB", bytes / 1e6)
    }

    fun count(value: Long): String = String.format(Locale.getDefault(), "%,d", value)

    /** Large ones in short: "1.9 M". */
    fun millions(value: Long): String =
        if (value < 100_000) count(value) else String.format(Locale.getDefault(), "%.1f M", value / 1e6)

    fun milliseconds(value: Double): String = String.format(Locale.getDefault(), "%.1f ms", value)
}
