package org.fluxgs.app

import android.content.Context

/** Settings of the viewer for all scenes. */
data class Settings(
    /** Scale of the blended image, 0.2 to 1; 0: the one that holds the display's rate. */
    val scale: Float = 0f,
    /** 0: what suits the device, 1: GPU, 2: CPU. */
    val sorter: Int = 0,
    val shDegree: Int = 3,
    /** 0: all. */
    val maxSplats: Int = 0,
    val hud: Boolean = false,
    /** A scene that is opened turns slowly until it is touched. */
    val autoOrbit: Boolean = true,
    /** Behind the scene: red, green and blue, one of [BACKDROPS]. */
    val backdrop: Int = 0,
    /** The largest scale while something moves, where [scale] is 0. */
    val movingScale: Float = 1f,
    /** Frames a second at most; 0: as many as the display has. */
    val mostFrames: Int = 0,
) {
    fun save(context: Context) {
        preferences(context).edit()
            .putFloat("scale", scale)
            .putInt("sorter", sorter)
            .putInt("shDegree", shDegree)
            .putInt("maxSplats", maxSplats)
            .putBoolean("hud", hud)
            .putBoolean("autoOrbit", autoOrbit)
            .putInt("backdrop", backdrop)
            .putFloat("movingScale", movingScale)
            .putInt("mostFrames", mostFrames)
            .apply()
    }

    companion object {
        val SCALES = floatArrayOf(0f, 1f, 0.85f, 0.7f, 0.5f)
        val BACKDROPS = intArrayOf(0x000000, 0x808080, 0xFFFFFF) // black, which scenes are made for, grey, white
        val BUDGETS = intArrayOf(0, 1_000_000, 500_000, 250_000, 100_000)

        fun load(context: Context): Settings {
            val kept = preferences(context)
            val defaults = Settings()
            return Settings(
                SCALES.find { it == kept.getFloat("scale", defaults.scale) } ?: defaults.scale,
                kept.getInt("sorter", defaults.sorter).coerceIn(0, 2),
                kept.getInt("shDegree", defaults.shDegree).coerceIn(0, 3),
                BUDGETS.find { it == kept.getInt("maxSplats", defaults.maxSplats) } ?: 0,
                kept.getBoolean("hud", defaults.hud),
                kept.getBoolean("autoOrbit", defaults.autoOrbit),
                BACKDROPS.find { it == kept.getInt("backdrop", defaults.backdrop) } ?: defaults.backdrop,
                SCALES.find { it > 0 && it == kept.getFloat("movingScale", 1f) } ?: 1f,
                kept.getInt("mostFrames", 0).coerceIn(0, 240),
            )
        }

        private fun preferences(context: Context) =
            context.getSharedPreferences("settings", Context.MODE_PRIVATE)
    }
}
