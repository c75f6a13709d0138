package org.fluxgs.app

import android.annotation.TargetApi
import android.content.Context
import android.os.Build
import android.os.PowerManager
import org.json.JSONObject

/** Thermal status of the device. */
data class Heat(
    /** PowerManager.THERMAL_STATUS_…, 0 to 6; -1 where it is not known. */
    val status: Int = -1,
    /** 1 where severe throttling begins; NaN where it is not known. */
    val headroom: Float = Float.NaN,
) {
    fun toJson(): JSONObject = JSONObject()
        .put("status", status)
        .put("headroom", if (headroom.isNaN()) JSONObject.NULL else headroom.toDouble())
}

internal class Thermals(context: Context) {
    private val power = context.getSystemService(PowerManager::class.java)
    private var asked = 0L
    private var headroom = Float.NaN

    fun now(): Heat = Heat(
        if (Build.VERSION.SDK_INT >= 29) status() else -1,
        if (Build.VERSION.SDK_INT >= 30) headroom() else Float.NaN,
    )

    @TargetApi(29)
    private fun status() = power.currentThermalStatus

    /** The system answers NaN to whoever asks more often than once a second. */
    @TargetApi(30)
    private fun headroom(): Float {
        val now = System.nanoTime()
        if (asked == 0L || now - asked > 10_000_000_000L) {
            asked = now
            headroom = power.getThermalHeadroom(FORECAST_SECONDS)
        }
        return headroom
    }

    companion object {
        const val SEVERE = 3
        private const val FORECAST_SECONDS = 10
    }
}
