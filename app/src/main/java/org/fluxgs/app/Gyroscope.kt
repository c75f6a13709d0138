package org.fluxgs.app

import android.app.Activity
import android.hardware.Sensor
import android.hardware.SensorEvent
import android.hardware.SensorEventListener
import android.hardware.SensorManager
import android.view.Surface

/** Hands the device's attitude on while it is [on], as [Session.turn] wants it. */
internal class Gyroscope(
    private val activity: Activity,
    private val turn: (rotation: FloatArray, screenTurns: Int, nanoseconds: Long) -> Unit,
) : SensorEventListener {
    private val manager = activity.getSystemService(SensorManager::class.java)
    private val sensor = manager.getDefaultSensor(Sensor.TYPE_GAME_ROTATION_VECTOR)
        ?: manager.getDefaultSensor(Sensor.TYPE_ROTATION_VECTOR)
    private val quaternion = FloatArray(4)

    val isThere get() = sensor != null

    var on = false
        set(value) {
            if (value == field || sensor == null) return
            field = value
            if (value) manager.registerListener(this, sensor, PERIOD_US)
            else manager.unregisterListener(this)
        }

    override fun onSensorChanged(event: SensorEvent) {
        SensorManager.getQuaternionFromVector(quaternion, event.values) // w, x, y, z
        val (w, x, y, z) = quaternion
        turn(floatArrayOf(x, y, z, w), screenTurns(), event.timestamp)
    }

    override fun onAccuracyChanged(sensor: Sensor?, accuracy: Int) = Unit

    @Suppress("DEPRECATION") // Activity.display is of newer Android only
    private fun screenTurns(): Int = when (activity.windowManager.defaultDisplay.rotation) {
        Surface.ROTATION_90 -> 1
        Surface.ROTATION_180 -> 2
        Surface.ROTATION_270 -> 3
        else -> 0
    }

    private companion object {
        const val PERIOD_US = 5_000 // more often than any display; the most that needs no permission
    }
}
