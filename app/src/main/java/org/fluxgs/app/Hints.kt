package org.fluxgs.app

import android.content.Context
import android.os.Build
import android.annotation.TargetApi
import android.view.View

/** The three gestures, told once, over the first scene that is drawn. */
internal class Hints(private val root: View) {
    private val kept = root.context.getSharedPreferences("hints", Context.MODE_PRIVATE)

    init {
        root.findViewById<View>(R.id.hints_done).setOnClickListener { done() }
        root.setOnClickListener { done() }
        if (Build.VERSION.SDK_INT >= 28) nameForReaders()
    }

    /** Screen readers tell of a pane that appears, and begin there. */
    @TargetApi(28)
    private fun nameForReaders() {
        root.accessibilityPaneTitle = root.context.getString(R.string.hint_title)
    }

    fun showOnce() {
        if (kept.getBoolean(TOLD, false) || root.visibility == View.VISIBLE) return
        root.visibility = View.VISIBLE
    }

    private fun done() {
        tell(root.context)
        root.visibility = View.GONE
    }

    companion object {
        private const val TOLD = "gestures"

        /** They have been told. */
        fun tell(context: Context) =
            context.getSharedPreferences("hints", Context.MODE_PRIVATE).edit().putBoolean(TOLD, true).apply()
    }
}
