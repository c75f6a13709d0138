package org.fluxgs.app

import android.content.Context
import android.net.Uri
import android.os.Handler
import android.os.Looper
import java.io.File

/**
 * Scenes that are copied into the [Library] one after the other; one that fails does not stop the others. For
 * the main thread. [onEnd] is called once all were tried, unless it is cancelled.
 */
internal class SceneBatch(context: Context, sources: List<SceneSource>, private val onEnd: () -> Unit) {
    class Failure(val source: SceneSource, val message: String)

    private val context = context.applicationContext
    private val main = Handler(Looper.getMainLooper())
    private val waiting = ArrayDeque(sources)
    private var cancelled = false
    val kept = mutableListOf<Uri>()
    val failures = mutableListOf<Failure>()

    /** What is copied now. */
    var source: SceneSource? = null
        private set
    var copy: SceneCopy? = null
        private set

    val done get() = kept.size + failures.size
    val size get() = done + waiting.size + if (source == null) 0 else 1

    fun start() {
        val next = waiting.removeFirstOrNull() ?: return onEnd()
        source = next
        val lookUp = Background.start { if (next.isFixed) kept(next) else null }
        Background.start { main.post { if (!cancelled) copyUnless(lookUp.get(), next) } }
    }

    /** Comes after those that are there. */
    fun add(sources: List<SceneSource>) {
        waiting += sources.filter { new -> new.uri != source?.uri && waiting.none { it.uri == new.uri } }
    }

    fun cancel() {
        cancelled = true
        copy?.cancel()
    }

    private fun kept(source: SceneSource): Uri? =
        Recents(context).find(source.uri)?.uri?.takeIf { Library(context).owns(it) && File(it.path!!).exists() }

    private fun copyUnless(known: Uri?, next: SceneSource) {
        if (known != null) return ended(next, SceneCopy.Kept(known))
        copy = SceneCopy.start(context, next).apply { onEnd { ended(next, it) } }
    }

    private fun ended(of: SceneSource, end: SceneCopy.End) {
        when (end) {
            is SceneCopy.Kept -> kept += end.uri
            is SceneCopy.Failed -> failures += Failure(of, end.message)
            SceneCopy.Cancelled -> {
                if (cancelled) return
                failures += Failure(of, context.getString(R.string.stopped_by_user)) // in the list
            }
        }
        source = null
        copy = null
        start()
    }
}
