package org.fluxgs.app

import android.content.Intent

/** Measurements of a benchmark. On the command line: `-e sizes 1280x720,640x480 -e frames 50 -e warmup 10`. */
data class BenchmarkPlan(
    /** Width and height of each. */
    val sizes: IntArray = intArrayOf(1280, 720, 1920, 1080),
    val warmup: Int = 20,
    val frames: Int = 100,
    val gpuSort: Boolean = true,
    val cpuSort: Boolean = true,
    /** More than 1: blended front to back in so many parts, skipping finished pixels. */
    val slices: Int = 1,
) {
    override fun equals(other: Any?) = other is BenchmarkPlan && sizes.contentEquals(other.sizes) &&
        warmup == other.warmup && frames == other.frames && gpuSort == other.gpuSort &&
        cpuSort == other.cpuSort && slices == other.slices

    override fun hashCode() = sizes.contentHashCode() * 31 + frames

    companion object {
        private const val MAX_FRAMES = 10_000
        private const val LARGEST = 8192
        private const val MOST_SLICES = 64

        /** Throws an IllegalArgumentException for a value that is no number or out of its range. */
        fun of(intent: Intent): BenchmarkPlan {
            val defaults = BenchmarkPlan()
            val sorter = intent.getStringExtra("sorter") ?: "both"
            require(sorter in setOf("both", "gpu", "cpu")) { "sorter '$sorter' is not gpu, cpu or both" }
            return BenchmarkPlan(
                intent.getStringExtra("sizes")?.let { sizesOf(it) } ?: defaults.sizes,
                number(intent, "warmup", defaults.warmup, 0),
                number(intent, "frames", defaults.frames, 1),
                sorter != "cpu",
                sorter != "gpu",
                number(intent, "slices", defaults.slices, 1, MOST_SLICES),
            )
        }

        private fun number(intent: Intent, name: String, default: Int, min: Int, max: Int = MAX_FRAMES): Int {
            // am start gives texts (-e) or integers (--ei)
            val text = intent.getStringExtra(name)
                ?: if (intent.hasExtra(name)) intent.getIntExtra(name, default).toString() else return default
            val value = text.toIntOrNull()
            require(value != null && value in min..max) {
                "$name '$text' is no number from $min to $max"
            }
            return value
        }

        private fun sizesOf(text: String): IntArray = text.split(',').flatMap { size ->
            val sides = size.trim().split('x').map { it.toIntOrNull() ?: 0 }
            require(sides.size == 2 && sides.all { it in 1..LARGEST }) {
                "size '$size' is not WIDTHxHEIGHT, 1 to $LARGEST each"
            }
            sides
        }.toIntArray()
    }
}
