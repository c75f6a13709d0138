package org.fluxgs.app

import android.view.View
import android.widget.Button
import android.widget.ProgressBar
import android.widget.TextView

/** Over a scene that is being opened, or cannot be. */
internal class LoadingView(
    private val root: View,
    onCancel: () -> Unit,
    onRetry: () -> Unit,
    onLeave: () -> Unit,
) {
    private val title = root.findViewById<TextView>(R.id.loading_title)
    private val detail = root.findViewById<TextView>(R.id.loading_detail)
    private val bar = root.findViewById<ProgressBar>(R.id.loading_bar)
    private val cancel = root.findViewById<Button>(R.id.loading_cancel)
    private val retry = root.findViewById<Button>(R.id.loading_retry)
    private val leave = root.findViewById<Button>(R.id.loading_leave)
    private var problem: Problem? = null // of opening, which the session does not know of
    private var looksAnew = 0 // at a scene whose graphics were given back while nobody saw it
    private var asks = false // whoever keeps the scene; what the session says is of the one before

    init {
        cancel.setOnClickListener { onCancel() }
        retry.setOnClickListener { onRetry() }
        leave.setOnClickListener { onLeave() }
    }

    /** [again]: whether that could help. */
    private data class Problem(val message: String, val again: Boolean = true)

    fun opening() {
        problem = null
        asks = true
        progress(root.context.getString(R.string.opening), "", -1)
    }

    /** The session has it. */
    fun loads() {
        asks = false
    }

    fun failed(message: String, again: Boolean = true) {
        problem = Problem(message, again).also { tell(it) }
    }

    /** The app that keeps the scene takes its time: perhaps it fetches it from far away. */
    fun slow() = progress(
        root.context.getString(R.string.opening), root.context.getString(R.string.provider_slow), -1,
    )

    fun hide() {
        problem = null
        asks = false
        root.visibility = View.GONE
    }

    /** [name]: of what is loaded; of what is drawn, while nothing is. */
    fun show(state: SessionState, name: String) {
        val loading = state.loading
        looksAnew = if (state.drawn && state.stats.memory == 0L) looksAnew + 1 else 0
        when {
            problem != null -> tell(problem!!)
            asks -> return
            loading.failed -> tell(Problem(loading.error))
            loading.phase == "reading" -> showReading(loading, name)
            loading.phase == "decoding" -> progress(
                root.context.getString(R.string.loading, name), estimateOf(loading), -1,
            )
            state.error.isNotEmpty() -> tell(Problem(state.error))
            loading.ready && !state.drawn -> progress(
                root.context.getString(R.string.loading, name), estimateOf(loading), -1,
            )
            looksAnew > 1 -> showAnew(name)
            loading.ready || state.drawn -> root.visibility = View.GONE
        }
    }

    private fun showAnew(name: String) {
        progress(root.context.getString(R.string.loading, name), "", -1)
        cancel.visibility = View.GONE
    }

    private fun showReading(loading: Loading, name: String) {
        val context = root.context
        val part = if (loading.bytes > 0) (1000 * loading.read / loading.bytes).toInt() else -1
        val detail =
            if (loading.bytes > 0) context.getString(
                R.string.read_of, Texts.megabytes(loading.read), Texts.megabytes(loading.bytes),
            )
            else Texts.megabytes(loading.read)
        val more = if (loading.splats > 0) "\n" + context.getString(
            R.string.will_take, Texts.count(loading.splats), Texts.megabytes(2 * loading.memory),
        ) else ""
        progress(context.getString(R.string.loading, name), detail + more, part)
    }

    /** Memory that it will take, once the file tells. */
    private fun estimateOf(loading: Loading): String =
        if (loading.splats == 0L) Texts.megabytes(loading.read)
        else root.context.getString(
            R.string.estimate, Texts.megabytes(loading.read), Texts.count(loading.splats),
            Texts.megabytes(2 * loading.memory),
        )

    private fun progress(text: String, more: String, thousandths: Int) {
        root.visibility = View.VISIBLE
        set(title, text)
        set(detail, more)
        detail.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_NONE // it counts
        bar.visibility = View.VISIBLE
        bar.isIndeterminate = thousandths < 0
        bar.progress = thousandths.coerceAtLeast(0)
        cancel.visibility = View.VISIBLE
        retry.visibility = View.GONE
        leave.visibility = View.GONE
    }

    /** Screen readers read out every new text. */
    private fun set(view: TextView, text: String) {
        if (view.text.toString() != text) view.text = text
    }

    private fun tell(problem: Problem) {
        root.visibility = View.VISIBLE
        set(title, root.context.getString(R.string.cannot_open))
        detail.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_POLITE
        set(detail, problem.message)
        bar.visibility = View.GONE
        cancel.visibility = View.GONE
        retry.visibility = if (problem.again) View.VISIBLE else View.GONE
        leave.visibility = View.VISIBLE
    }
}
