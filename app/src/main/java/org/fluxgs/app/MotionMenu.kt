package org.fluxgs.app

import android.content.Context
import android.view.View
import android.widget.PopupMenu

/** The menu of what moves the view. */
internal class MotionMenu(private val context: Context, private val session: () -> Session) {
    fun show(anchor: View) {
        val popup = PopupMenu(context, anchor)
        val motion = session().state()?.motion
        check(popup, R.string.auto_orbit, motion == "drift") { session().drift(it) }
        popup.show()
    }

    private fun check(popup: PopupMenu, label: Int, on: Boolean, action: (Boolean) -> Unit) {
        val item = popup.menu.add(label)
        item.isCheckable = true
        item.isChecked = on
        item.setOnMenuItemClickListener {
            action(!on)
            true
        }
    }
}
