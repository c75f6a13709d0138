package org.fluxgs.app

import android.content.ContentResolver
import android.content.Context
import android.net.Uri

/**
 * Over a scene of another app: whether the app is to keep a copy of it, and how far that is. onKept is called
 * once the scene is the app's own.
 */
internal class CopyOffer(
    private val context: Context,
    private val notice: Notice,
    private val onKept: (source: Uri, copy: Uri) -> Unit,
    private val say: (String) -> Unit,
) {
    private val recents = Recents(context)
    private var scene: Uri? = null // that is looked at
    private var watched: SceneCopy? = null

    /** Another scene is looked at, of so many bytes. */
    fun show(uri: Uri, name: String, bytes: Long, onMain: (() -> Unit) -> Unit) {
        if (uri == scene) return
        scene = uri
        notice.hide()
        if (uri.scheme != ContentResolver.SCHEME_CONTENT) return
        SceneCopy.of(uri)?.let { return watch(it) }
        Background.start {
            val known = recents.find(uri)
            onMain { if (scene == uri) offer(uri, name, bytes, known) }
        }
    }

    private fun offer(uri: Uri, name: String, bytes: Long, known: Recent?) {
        if (known?.source == uri && known.bytes == bytes) return onKept(uri, known.uri)
        if (known?.declined == true) return
        notice.show(
            context.getString(R.string.keep_question, Texts.size(context, bytes)),
            Notice.Answer(R.string.keep_copy) { watch(SceneCopy.start(context, uri, name)) },
            Notice.Answer(R.string.not_now) { Background.start { recents.decline(uri) } },
        )
    }

    private fun watch(copy: SceneCopy) {
        watched = copy
        copy.onEnd { end ->
            if (watched === copy) watched = null
            if (scene == copy.source) notice.hide()
            when (end) {
                is SceneCopy.Kept -> {
                    if (scene == copy.source) scene = end.uri
                    onKept(copy.source, end.uri)
                    say(context.getString(R.string.copy_kept))
                }
                is SceneCopy.Failed -> say(end.message)
                SceneCopy.Cancelled -> Unit
            }
        }
        look()
    }

    /** To be called often. */
    fun look() {
        val copy = watched ?: return
        if (scene != copy.source) return
        val part = if (copy.bytes > 0) copy.copied.toFloat() / copy.bytes else -1f
        notice.progress(SceneCards.progressOf(context, copy), part, Notice.Answer(R.string.cancel) { copy.cancel() })
    }
}
