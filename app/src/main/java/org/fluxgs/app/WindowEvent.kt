package org.fluxgs.app

import android.view.KeyEvent
import android.view.MotionEvent

/** What a mouse or a keyboard does, as viewer/window_event.h has it. */
class WindowEvent(
    val kind: Int,
    val x: Float = 0f,
    val y: Float = 0f,
    val button: Int = 0,
    val down: Boolean = false,
    val amount: Float = 0f,
    val key: Char = '\u0000',
) {
    companion object {
        private const val MOVED = 0
        private const val BUTTON = 1
        private const val SCROLLED = 2
        private const val KEY = 3
        private const val TYPED = 4
        private const val FOCUS_LOST = 5

        val focusLost get() = WindowEvent(FOCUS_LOST)

        fun isOfMouse(event: MotionEvent) = event.getToolType(0) == MotionEvent.TOOL_TYPE_MOUSE

        /** [ratio]: pixels of the scene's image in one of the view. [pressed]: the button that is down. */
        fun of(event: MotionEvent, ratio: Float, pressed: Int): WindowEvent? {
            val x = ratio * event.x
            val y = ratio * event.y
            return when (event.actionMasked) {
                MotionEvent.ACTION_DOWN -> WindowEvent(BUTTON, x, y, pressed, down = true)
                MotionEvent.ACTION_UP, MotionEvent.ACTION_CANCEL -> WindowEvent(BUTTON, x, y, pressed)
                MotionEvent.ACTION_MOVE -> WindowEvent(MOVED, x, y)
                MotionEvent.ACTION_SCROLL ->
                    WindowEvent(SCROLLED, x, y, amount = event.getAxisValue(MotionEvent.AXIS_VSCROLL))
                else -> null
            }
        }

        /** 0 left, 1 middle, 2 right. */
        fun buttonOf(event: MotionEvent) = when {
            event.isButtonPressed(MotionEvent.BUTTON_SECONDARY) -> 2
            event.isButtonPressed(MotionEvent.BUTTON_TERTIARY) -> 1
            else -> 0
        }

        /** Keys by their places, and what they write; none with Ctrl, Alt or Meta, which are the system's. */
        fun of(event: KeyEvent): List<WindowEvent> {
            if (event.isCtrlPressed || event.isAltPressed || event.isMetaPressed) return emptyList()
            val down = event.action == KeyEvent.ACTION_DOWN
            val letter = event.keyCode - KeyEvent.KEYCODE_A
            val held = if (letter in 0..25 && event.repeatCount == 0)
                listOf(WindowEvent(KEY, down = down, key = 'A' + letter)) else emptyList()
            val char = event.unicodeChar
            if (!down || char !in 33..126) return held
            return held + WindowEvent(TYPED, key = char.toChar())
        }
    }
}
