package org.fluxgs.app

import android.os.Bundle
import android.os.SystemClock
import android.view.View
import android.view.accessibility.AccessibilityNodeInfo
import android.view.accessibility.AccessibilityNodeInfo.AccessibilityAction

/**
 * What fingers do to a scene, for those who use TalkBack or a switch instead: by name, from the menu
 * of actions. They are done by fingers that nobody sees.
 */
internal class SceneActions : View.AccessibilityDelegate() {
    /** Fingers go from a place to another, both in parts of the view's shorter side from its middle. */
    private class Way(val fromX: Float, val fromY: Float, val toX: Float, val toY: Float)

    private class Action(val id: Int, val label: Int, vararg val ways: Way)

    private val actions = listOf(
        Action(R.id.look_left, R.string.look_left, Way(0f, 0f, STEP, 0f)),
        Action(R.id.look_right, R.string.look_right, Way(0f, 0f, -STEP, 0f)),
        Action(R.id.look_higher, R.string.look_higher, Way(0f, 0f, 0f, STEP)),
        Action(R.id.look_lower, R.string.look_lower, Way(0f, 0f, 0f, -STEP)),
        Action(R.id.come_nearer, R.string.come_nearer, Way(-.2f, 0f, -.25f, 0f), Way(.2f, 0f, .25f, 0f)),
        Action(R.id.go_away, R.string.go_away, Way(-.25f, 0f, -.2f, 0f), Way(.25f, 0f, .2f, 0f)),
    )

    override fun onInitializeAccessibilityNodeInfo(host: View, info: AccessibilityNodeInfo) {
        super.onInitializeAccessibilityNodeInfo(host, info)
        val tap = host.context.getString(R.string.toggle_controls)
        info.addAction(AccessibilityAction(AccessibilityNodeInfo.ACTION_CLICK, tap))
        for (action in actions)
            info.addAction(AccessibilityAction(action.id, host.context.getString(action.label)))
    }

    override fun performAccessibilityAction(host: View, id: Int, arguments: Bundle?): Boolean {
        val action = actions.find { it.id == id }
            ?: return super.performAccessibilityAction(host, id, arguments)
        val surface = host as SceneSurface
        val session = surface.session ?: return false
        move(session, surface.ratio * surface.width, surface.ratio * surface.height, action.ways)
        return true
    }

    private fun move(session: Session, width: Float, height: Float, ways: Array<out Way>) {
        val ids = IntArray(ways.size) { FIRST_ID + it }
        val unit = minOf(width, height)
        fun places(x: (Way) -> Float, y: (Way) -> Float) = FloatArray(2 * ways.size) {
            val way = ways[it / 2]
            if (it % 2 == 0) width / 2 + unit * x(way) else height / 2 + unit * y(way)
        }
        val from = places({ it.fromX }, { it.fromY })
        val to = places({ it.toX }, { it.toY })
        val now = SystemClock.uptimeMillis()
        for (i in ids.indices)
            session.touch(DOWN, ids[i], ids.copyOf(i + 1), from.copyOf(2 * (i + 1)), now)
        session.touch(MOVED, ids[0], ids, to, now)
        session.touch(MOVED, ids[0], ids, to, now + REST_MS) // so that it does not glide on
        for (i in ids.indices.reversed())
            session.touch(UP, ids[i], ids.copyOf(i + 1), to.copyOf(2 * (i + 1)), now + REST_MS)
    }

    private companion object {
        const val STEP = 0.15f
        const val REST_MS = 500L
        const val FIRST_ID = 100 // those of real fingers are smaller
        const val DOWN = 0
        const val MOVED = 1
        const val UP = 2
    }
}
