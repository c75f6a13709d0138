package org.fluxgs.app

/**
 * How long a transfer still takes, by the rate of its last seconds: a connection has no steady one. Nothing is
 * said while there is too little to go by.
 */
internal class TimeLeft {
    private class Sample(val at: Long, val done: Long)

    private val samples = ArrayDeque<Sample>()

    /** [now]: ms of any clock; [all]: less than 0 where nobody knows. To be asked often. */
    fun seconds(now: Long, done: Long, all: Long): Long? {
        if (samples.isNotEmpty() && done < samples.last().done) samples.clear() // another one
        samples += Sample(now, done)
        while (now - samples[1.coerceAtMost(samples.size - 1)].at >= WINDOW_MS) samples.removeFirst()
        val elapsed = now - samples.first().at
        val moved = done - samples.first().done
        if (all < 0 || elapsed < LEAST_MS || moved <= 0) return null
        return (elapsed * ((all - done).toDouble() / moved) / 1000).toLong()
    }

    private companion object {
        const val WINDOW_MS = 10_000
        const val LEAST_MS = 2_000
    }
}
