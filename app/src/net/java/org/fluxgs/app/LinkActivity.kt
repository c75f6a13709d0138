package org.fluxgs.app

import android.app.AlertDialog
import android.content.Intent
import android.text.InputType
import android.widget.EditText
import android.widget.FrameLayout

/** Downloads what a link leads to into the library: one that was tapped, shared, or is typed here. */
class LinkActivity : AddScenesActivity() {
    override fun begin(intent: Intent, done: Int) =
        if (intent.action == Intent.ACTION_VIEW || intent.action == Intent.ACTION_SEND) super.begin(intent, done)
        else askForLink("", null)

    override fun sourcesOf(intent: Intent): List<SceneSource> {
        val uri = if (intent.action == Intent.ACTION_VIEW) intent.data
        else intent.getCharSequenceExtra(Intent.EXTRA_TEXT)?.let { Link.find(it.toString()) }
        return listOfNotNull(uri?.let { Link(applicationContext, it) })
    }

    private fun askForLink(typed: String, problem: String?) {
        val field = EditText(this).apply {
            id = R.id.name
            inputType = InputType.TYPE_CLASS_TEXT or InputType.TYPE_TEXT_VARIATION_URI
            hint = getString(R.string.link_hint)
            setText(typed)
            error = problem
        }
        val side = (20 * resources.displayMetrics.density).toInt()
        AlertDialog.Builder(this)
            .setTitle(R.string.open_link)
            .setView(FrameLayout(this).apply {
                setPadding(side, 0, side, 0)
                addView(field)
            })
            .setPositiveButton(R.string.link_open) { _, _ -> open(field.text.toString()) }
            .setNegativeButton(R.string.cancel) { _, _ -> finish() }
            .setOnCancelListener { finish() }
            .show()
    }

    private fun open(typed: String) {
        val link = Link.find(typed) ?: return askForLink(typed, getString(R.string.link_broken))
        add(listOf(Link(applicationContext, link)))
    }
}
