package org.fluxgs.app

import android.app.ActivityManager
import android.content.Context

/** Memory that a scene may take without the system ending the app. */
internal object FreeMemory {
    /** Bytes left to everything else. */
    private const val KEPT = 150L shl 20

    /**
     * Bytes for a scene, together with its file where that is read as a whole. Decoding holds as much
     * again for a while, and then the GPU may have as much for drawing it; no second copy of the scene
     * is made for that. What does not fit is left out.
     */
    fun forScene(context: Context): Long {
        val info = ActivityManager.MemoryInfo()
        context.getSystemService(ActivityManager::class.java).getMemoryInfo(info)
        val free = info.availMem - info.threshold - KEPT
        return (free / 2).coerceIn(64L shl 20, 4L shl 30)
    }

    /** True if the system is about to end apps for want of memory. */
    fun isLow(context: Context): Boolean {
        val info = ActivityManager.MemoryInfo()
        context.getSystemService(ActivityManager::class.java).getMemoryInfo(info)
        return info.lowMemory
    }

    /** Bytes of the GPU, which shares the device's memory. */
    fun forGraphics(context: Context): Long = forScene(context)
}
