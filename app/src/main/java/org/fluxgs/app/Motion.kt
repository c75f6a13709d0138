package org.fluxgs.app

import android.content.Context
import android.provider.Settings.Global

/** Whether what moves by itself may do so. */
internal object Motion {
    /** False where the system was asked to reduce motion: its animations are off. */
    fun isWelcome(context: Context) =
        Global.getFloat(context.contentResolver, Global.ANIMATOR_DURATION_SCALE, 1f) > 0
}
