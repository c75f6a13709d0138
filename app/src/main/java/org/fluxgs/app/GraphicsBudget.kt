package org.fluxgs.app

import android.content.Context
import android.os.SystemClock

/**
 * How much graphics memory a scene may take. Less when the system wants some back: three quarters of
 * what is taken, so that bits that few see and splats that add little go before pixels do. More again
 * when there is room, each time after a longer wait, for it is not to change to and fro.
 */
internal class GraphicsBudget(private val context: Context) {
    var bytes = FreeMemory.forGraphics(context)
        private set
    private var askAt = 0L
    private var settledAt = 0L
    private var growAt = 0L
    private var patience = FIRST_PATIENCE_MS

    /** Another scene may have what there is now. */
    fun begin() {
        bytes = FreeMemory.forGraphics(context).coerceAtLeast(bytes)
    }

    /**
     * To be called often: from Android 14 on nobody tells, so it asks, now and then. [taken] are bytes
     * of graphics memory, which is [reduced] where there was no room for all. Whether [bytes] have
     * changed.
     */
    fun look(taken: Long, reduced: Boolean): Boolean {
        val now = SystemClock.elapsedRealtime()
        if (now < askAt) return false
        askAt = now + ASK_EVERY_MS
        return if (FreeMemory.isLow(context)) shrink(taken) else reduced && now >= growAt && grow()
    }

    /** The system wants memory back. Whether [bytes] have changed. */
    fun shrink(taken: Long): Boolean {
        val now = SystemClock.elapsedRealtime()
        if (taken == 0L || now < settledAt) return false
        settledAt = now + EFFECT_MS
        growAt = now + patience
        patience = (2 * patience).coerceAtMost(LONGEST_PATIENCE_MS)
        val less = (bytes.coerceAtMost(taken) / 4 * 3).coerceAtLeast(LEAST)
        if (less >= bytes) return false
        bytes = less
        return true
    }

    private fun grow(): Boolean {
        val free = FreeMemory.forGraphics(context)
        if (free < bytes / 3 * 4) return false // too little to be seen
        bytes = free
        return true
    }

    companion object {
        const val LEAST = 16L shl 20 // with which there is still an image
        const val ASK_EVERY_MS = 5_000L
        const val EFFECT_MS = 30_000L // what was let go of has an effect by then
        const val FIRST_PATIENCE_MS = 60_000L
        private const val LONGEST_PATIENCE_MS = 16 * 60_000L
    }
}
