package org.fluxgs.app

import android.os.SystemClock
import android.view.View
import android.view.accessibility.AccessibilityManager

/**
 * Shows and hides the tools over a scene: by a tap, and by themselves while the scene has moved for a while,
 * until it rests. They stay for who explores the screen by touch.
 */
internal class ToolsFade(private val tools: View) {
    private val accessibility = tools.context.getSystemService(AccessibilityManager::class.java)
    private var movesSince = 0L
    private var faded = false

    /** Somebody does not want them. */
    var hidden = false
        private set

    fun toggle() = if (faded || hidden) showAgain() else hide()

    fun hide() {
        hidden = true
        tools.animate().cancel()
        tools.visibility = View.GONE
    }

    /** To be called often. */
    fun look(moves: Boolean) {
        val now = SystemClock.elapsedRealtime()
        if (!moves) movesSince = 0
        else if (movesSince == 0L) movesSince = now
        if (hidden) return
        val fades = moves && now - movesSince >= FADE_AFTER_MS && !accessibility.isTouchExplorationEnabled
        if (fades && !faded) fade()
        if (!moves && faded) showAgain()
    }

    private fun fade() {
        faded = true
        tools.animate().alpha(0f).setDuration(FADE_MS)
            .withEndAction { if (faded) tools.visibility = View.INVISIBLE }
    }

    private fun showAgain() {
        faded = false
        hidden = false
        movesSince = 0 // for as long again
        tools.visibility = View.VISIBLE
        tools.animate().alpha(1f).setDuration(FADE_MS)
    }

    companion object {
        const val FADE_AFTER_MS = 3000L
        private const val FADE_MS = 300L
    }
}
