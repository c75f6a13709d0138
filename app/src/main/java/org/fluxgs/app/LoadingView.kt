package org.fluxgs.app

import android.graphics.Bitmap
import android.view.View
import android.widget.Button
import android.widget.CheckBox
import android.widget.ImageView
import android.widget.ProgressBar
import android.widget.TextView

/**
 * Why a scene cannot be shown: in words for people, and as the machine has it. [name]: of the scene, if there is
 * one; [again]: whether another try could help; [title]: where it is not that a scene cannot be opened.
 */
internal data class Problem(
    val message: String, val cause: String = "", val name: String = "", val again: Boolean = true,
    val title: String = "",
)

/** Over a scene that is being opened, or cannot be. */
internal class LoadingView(private val root: View, actions: Actions) {
    /** What its buttons do. */
    class Actions(val cancel: () -> Unit, val retry: () -> Unit, val leave: () -> Unit, val choose: () -> Unit)

    private val context = root.context
    private val title = root.findViewById<TextView>(R.id.loading_title)
    private val detail = root.findViewById<TextView>(R.id.loading_detail)
    private val bar = root.findViewById<ProgressBar>(R.id.loading_bar)
    private val cancel = root.findViewById<Button>(R.id.loading_cancel)
    private val retry = root.findViewById<Button>(R.id.loading_retry)
    private val leave = root.findViewById<Button>(R.id.loading_leave)
    private val choose = root.findViewById<Button>(R.id.loading_choose)
    private val unfold = root.findViewById<CheckBox>(R.id.loading_unfold)
    private val cause = root.findViewById<TextView>(R.id.loading_cause)
    private val preview = root.findViewById<ImageView>(R.id.preview)
    private var problem: Problem? = null // of opening, which the session does not know of
    private var looksAnew = 0 // at a scene whose graphics were given back while nobody saw it
    private var asks = false // whoever keeps the scene; what the session says is of the one before

    init {
        cancel.setOnClickListener { actions.cancel() }
        retry.setOnClickListener { actions.retry() }
        leave.setOnClickListener { actions.leave() }
        choose.setOnClickListener { actions.choose() }
        unfold.setOnCheckedChangeListener { _, on -> cause.visibility = if (on) View.VISIBLE else View.GONE }
    }

    fun opening() {
        problem = null
        asks = true
        preview.setImageDrawable(null)
        progress(context.getString(R.string.opening), "", -1)
    }

    /** How the scene looked: small, so that it is seen blurred. */
    fun preview(image: Bitmap) {
        val height = (PREVIEW * image.height / image.width).coerceAtLeast(1)
        preview.setImageBitmap(Bitmap.createScaledBitmap(image, PREVIEW, height, true))
    }

    /** The session has it. */
    fun loads() {
        asks = false
    }

    fun failed(problem: Problem) {
        this.problem = problem
        tell(problem)
    }

    /** The app that keeps the scene takes its time: perhaps it fetches it from far away. */
    fun slow() = progress(context.getString(R.string.opening), context.getString(R.string.provider_slow), -1)

    fun hide() {
        problem = null
        asks = false
        root.visibility = View.GONE
        preview.setImageDrawable(null)
    }

    /**
     * [name]: of what is loaded; of what is drawn, while nothing is. [memory]: bytes that a scene may take,
     * asked for where that matters.
     */
    fun show(state: SessionState, name: String, memory: () -> Long) {
        val loading = state.loading
        if (state.coarse) preview.setImageDrawable(null)
        looksAnew = if (state.drawn && state.stats.memory == 0L) looksAnew + 1 else 0
        when {
            problem != null -> tell(problem!!)
            asks -> return
            loading.failed -> tell(problemOf(loading, name))
            loading.isBusy -> showLoading(loading, name, memory)
            state.error.isNotEmpty() ->
                tell(Problem(context.getString(R.string.scene_not_drawn), state.error, name))
            loading.ready && !state.drawn -> showLoading(loading, name, memory)
            looksAnew > 1 -> showAnew(name)
            loading.ready || state.drawn -> hide()
        }
    }

    private fun problemOf(loading: Loading, name: String) = Problem(
        context.getString(
            when (loading.problem) {
                "memory" -> R.string.scene_no_memory
                "read" -> R.string.scene_cut
                "open" -> R.string.scene_unreadable
                else -> R.string.scene_broken
            },
        ),
        loading.error, name,
    )

    private fun showAnew(name: String) {
        progress(context.getString(R.string.loading, Texts.titleOf(name)), "", -1)
        cancel.visibility = View.GONE
    }

    private fun showLoading(loading: Loading, name: String, memory: () -> Long) {
        val reads = loading.phase == "reading" && loading.bytes > 0
        val part = if (reads) (1000 * loading.read / loading.bytes).toInt() else -1
        val size = Texts.size(context, loading.read)
        val read = if (reads) context.getString(R.string.read_of, size, Texts.size(context, loading.bytes)) else size
        val lines = listOfNotNull(read, tightness(loading, memory))
        progress(context.getString(R.string.loading, Texts.titleOf(name)), lines.joinToString("\n"), part)
    }

    /** Memory is spoken of where there is little of it for what the file will take. */
    private fun tightness(loading: Loading, memory: () -> Long): String? {
        if (loading.memory == 0L) return null
        val free = memory()
        if (2 * loading.memory < free) return null
        return context.getString(
            R.string.memory_tight, Texts.size(context, 2 * loading.memory), Texts.size(context, 2 * free),
        )
    }

    /** [thousandths]: less than 0 where nobody knows how much there is. */
    fun progress(text: String, more: String, thousandths: Int) {
        root.visibility = View.VISIBLE
        set(title, text)
        set(detail, more)
        detail.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_NONE // it counts
        bar.visibility = View.VISIBLE
        bar.isIndeterminate = thousandths < 0
        bar.progress = thousandths.coerceAtLeast(0)
        cancel.visibility = View.VISIBLE
        for (view in listOf(retry, leave, choose, unfold, cause)) view.visibility = View.GONE
    }

    /** Screen readers read out every new text. */
    private fun set(view: TextView, text: String) {
        if (view.text.toString() != text) view.text = text
    }

    private fun tell(problem: Problem) {
        root.visibility = View.VISIBLE
        set(
            title,
            if (problem.title.isNotEmpty()) problem.title
            else if (problem.name.isNotEmpty()) context.getString(R.string.cannot_open_named, problem.name)
            else context.getString(R.string.cannot_open),
        )
        detail.accessibilityLiveRegion = View.ACCESSIBILITY_LIVE_REGION_POLITE
        set(detail, problem.message)
        set(cause, problem.cause)
        bar.visibility = View.GONE
        cancel.visibility = View.GONE
        choose.visibility = View.VISIBLE
        leave.visibility = View.VISIBLE
        retry.visibility = if (problem.again) View.VISIBLE else View.GONE
        unfold.visibility = if (problem.cause.isEmpty()) View.GONE else View.VISIBLE
        cause.visibility = if (unfold.isChecked && problem.cause.isNotEmpty()) View.VISIBLE else View.GONE
    }

    private companion object {
        const val PREVIEW = 24 // pixels across
    }
}
