package org.fluxgs.app

import android.view.View
import android.widget.Button
import android.widget.ProgressBar
import android.widget.TextView

/** Something that is said over the scene, with one or two answers to it. */
internal class Notice(private val root: View) {
    private val text = root.findViewById<TextView>(R.id.notice_text)
    private val bar = root.findViewById<ProgressBar>(R.id.notice_bar)
    private val no = root.findViewById<Button>(R.id.notice_no)
    private val yes = root.findViewById<Button>(R.id.notice_yes)
    private val end = Runnable { hide() }

    /** An answer: what it is called, and what it does after the notice is gone. */
    class Answer(val label: Int, val action: () -> Unit)

    /** [forMs]: how long; 0: until it is answered. */
    fun show(said: String, yes: Answer?, no: Answer? = null, forMs: Long = 0) {
        root.removeCallbacks(end)
        text.text = said
        text.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_POLITE
        bar.visibility = View.GONE
        offer(this.yes, yes)
        offer(this.no, no)
        root.visibility = View.VISIBLE
        if (forMs > 0) root.postDelayed(end, forMs)
    }

    /** [part]: 0 to 1, or less where it is not known. */
    fun progress(said: String, part: Float, cancel: Answer) {
        if (bar.visibility == View.GONE) show(said, null, cancel)
        text.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_NONE // it counts
        if (text.text.toString() != said) text.text = said
        bar.visibility = View.VISIBLE
        bar.isIndeterminate = part < 0
        bar.progress = (bar.max * part.coerceAtLeast(0f)).toInt()
    }

    fun hide() {
        root.removeCallbacks(end)
        root.visibility = View.GONE
    }

    private fun offer(button: Button, answer: Answer?) {
        button.visibility = if (answer == null) View.GONE else View.VISIBLE
        if (answer == null) return
        button.setText(answer.label)
        button.setOnClickListener {
            hide()
            answer.action()
        }
    }
}
