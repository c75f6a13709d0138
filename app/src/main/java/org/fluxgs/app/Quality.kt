package org.fluxgs.app

/** What people choose between: each stands for values of the [Settings]. */
internal enum class Quality(
    val choice: Int,
    val label: Int,
    val line: Int,
    private val scale: Float = 0f,
    private val movingScale: Float = 1f,
    private val mostFrames: Int = 0,
) {
    AUTOMATIC(R.id.automatic, R.string.quality_automatic, R.string.quality_automatic_line),
    SHARP(R.id.sharp, R.string.quality_sharp, R.string.quality_sharp_line, scale = 1f),
    BALANCED(R.id.balanced, R.string.quality_balanced, R.string.quality_balanced_line, movingScale = 0.7f),
    BATTERY(
        R.id.battery, R.string.quality_battery, R.string.quality_battery_line,
        movingScale = 0.5f, mostFrames = 30,
    );

    /** The settings with this quality; those that have nothing to do with it stay. */
    fun of(settings: Settings) = settings.copy(
        scale = scale, movingScale = movingScale, mostFrames = mostFrames,
        sorter = 0, shDegree = 3, maxSplats = 0,
    )

    companion object {
        /** Null where somebody has chosen values of their own. */
        fun ofSettings(settings: Settings) = entries.find { it.of(settings) == settings }
    }
}
