package org.fluxgs.app

import android.app.Activity
import android.content.ContentResolver
import android.content.Intent
import android.net.Uri
import android.os.BadParcelableException
import android.os.Bundle
import android.os.Handler
import android.os.Looper
import android.os.Parcelable
import android.os.SystemClock
import android.view.View
import android.widget.Toast

/** Copies what other apps share into the library, and says how that went. What comes meanwhile waits its turn. */
open class AddScenesActivity : Activity() {
    private lateinit var view: LoadingView
    private lateinit var card: View
    private var batch: SceneBatch? = null // until it has ended
    private var ended: SceneBatch? = null
    private var seen = false
    private val left = TimeLeft()
    private val main = Handler(Looper.getMainLooper())

    private val look = object : Runnable {
        override fun run() {
            showProgress()
            main.postDelayed(this, ViewerActivity.LOOK_EVERY_MS)
        }
    }

    override fun onCreate(state: Bundle?) {
        super.onCreate(state)
        setContentView(R.layout.loading)
        card = findViewById(R.id.loading)
        Insets.pad(card)
        val actions = LoadingView.Actions(::leave, ::retry, ::leave) { ScenePicker.ask(this) }
        view = LoadingView(card, actions)
        view.hide()
        begin(intent, state?.getInt(DONE) ?: 0)
    }

    override fun onNewIntent(intent: Intent) {
        super.onNewIntent(intent)
        setIntent(intent)
        begin(intent, 0)
    }

    /** [done]: of its scenes, before the app was ended. */
    internal open fun begin(intent: Intent, done: Int) = add(sourcesOf(intent).drop(done))

    internal open fun sourcesOf(intent: Intent): List<SceneSource> =
        streamsOf(intent).filter { it.scheme == ContentResolver.SCHEME_CONTENT }.distinct()
            .map { Document(applicationContext, it) }

    private fun streamsOf(intent: Intent): List<Uri> = try {
        @Suppress("DEPRECATION") // the typed one is of newer Android only
        intent.getParcelableArrayListExtra<Parcelable>(Intent.EXTRA_STREAM)?.filterIsInstance<Uri>() ?: emptyList()
    } catch (_: BadParcelableException) {
        emptyList()
    }

    internal fun add(sources: List<SceneSource>) {
        batch?.let { return it.add(sources) }
        if (sources.isEmpty()) return view.failed(Problem(getString(R.string.nothing_shared), again = false))
        view.opening()
        ended = null
        batch = SceneBatch(this, sources, ::end).apply { start() }
    }

    private fun showProgress() {
        val batch = batch ?: return
        val source = batch.source ?: return
        card.keepScreenOn = true
        val copy = batch.copy ?: return view.progress(titleOf(batch, source), source.origin, -1)
        val seconds = left.seconds(SystemClock.elapsedRealtime(), copy.copied, copy.bytes)
        val size = listOfNotNull(
            if (copy.copied > 0) SceneCards.sizeOf(this, copy) else null,
            seconds?.let { Texts.left(this, it) },
        ).joinToString(" · ")
        val part = if (copy.bytes > 0) (1000 * copy.copied / copy.bytes).toInt() else -1
        view.progress(titleOf(batch, source), listOf(size, source.origin).filter { it.isNotEmpty() }.joinToString("\n"), part)
    }

    private fun titleOf(batch: SceneBatch, source: SceneSource): String {
        val title = getString(R.string.adding, Texts.titleOf(source.name))
        return if (batch.size == 1) title else getString(R.string.adding_of, batch.done + 1, batch.size, title)
    }

    private fun end() {
        card.keepScreenOn = false
        ended = batch
        batch = null
        if (seen) tell()
    }

    /** Once somebody sees it: nothing is opened over other apps. */
    private fun tell() {
        val end = ended ?: return
        val failures = end.failures
        when {
            failures.isEmpty() && end.kept.size == 1 -> open(end.kept.single())
            failures.isEmpty() -> {
                Toast.makeText(this, summaryOf(end), Toast.LENGTH_LONG).show()
                leave()
            }
            end.size == 1 -> failures.single().let { view.failed(Problem(it.message, "${it.source.uri}", it.source.name)) }
            else -> view.failed(
                Problem(
                    getString(R.string.not_added, failures.joinToString { it.source.name }),
                    failures.joinToString("\n") { "${it.source.name}: ${it.message}" }, title = summaryOf(end),
                ),
            )
        }
    }

    private fun summaryOf(end: SceneBatch): String =
        getString(R.string.added, Texts.count(end.kept.size.toLong()), Texts.count(end.size.toLong()))

    private fun open(uri: Uri) {
        startActivity(Intent(this, ViewerActivity::class.java).setData(uri))
        finish()
    }

    private fun retry() {
        val again = ended?.failures?.map { it.source } ?: return
        ended = null
        add(again)
    }

    /** What was added before is in the list. */
    private fun leave() {
        batch?.cancel()
        if (ended?.kept?.isNotEmpty() == true) startActivity(Intent(this, ScenesActivity::class.java))
        finish()
    }

    override fun onResume() {
        super.onResume()
        seen = true
        tell()
        look.run()
    }

    override fun onPause() {
        seen = false
        main.removeCallbacks(look)
        super.onPause()
    }

    override fun onSaveInstanceState(state: Bundle) {
        super.onSaveInstanceState(state)
        state.putInt(DONE, (batch ?: ended)?.done ?: 0)
    }

    override fun onDestroy() {
        batch?.cancel()
        super.onDestroy()
    }

    @Deprecated("androidx's replacement is not worth its size here")
    override fun onActivityResult(request: Int, result: Int, data: Intent?) {
        ScenePicker.picked(this, request, result, data)?.let { open(it) }
    }

    private companion object {
        const val DONE = "done"
    }
}
