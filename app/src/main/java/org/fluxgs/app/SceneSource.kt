package org.fluxgs.app

import android.content.Context
import android.net.Uri
import android.os.CancellationSignal
import android.os.ParcelFileDescriptor
import java.io.BufferedInputStream
import java.io.FileNotFoundException
import java.io.IOException
import java.io.InputStream

/** Where a scene is copied from. */
internal interface SceneSource {
    /** By which it is known, later, too: [Recent.source]. */
    val uri: Uri

    /** With its ending; at the latest once it was opened, or could not be. */
    val name: String

    /** Whoever gives it, for people; empty where that says nothing. */
    val origin: String

    /** What is there stays as it is: what was copied once need not be copied again. */
    val isFixed: Boolean

    /** May wait for others, until the signal: not for the main thread. */
    fun open(signal: CancellationSignal): Stream

    /** What went wrong between [open] and the last byte, in words for people. */
    fun wordsFor(problem: IOException): String

    /** [bytes]: how many there are, -1 where nobody says. */
    class Stream(val input: InputStream, val bytes: Long)

    /** Something that has words for people already. */
    class Problem(message: String) : IOException(message)
}

/** Of another app: a scene that was looked at, with the [title] that people know it by, or anything. */
internal class Document(
    private val context: Context, override val uri: Uri, private val title: String? = null,
) : SceneSource {
    @Volatile
    override var name = title ?: uri.lastPathSegment?.substringAfterLast('/') ?: uri.toString()
        private set
    override val origin = ""
    override val isFixed = false

    override fun open(signal: CancellationSignal): SceneSource.Stream {
        val facts = Scene.factsOf(context, uri)
        name = title ?: facts.name
        val from = context.contentResolver.openFileDescriptor(uri, "r", signal)
            ?: throw FileNotFoundException(uri.toString())
        // By its own word, or for a pipe by that of the other app
        val bytes = if (from.statSize > 0) from.statSize else facts.bytes
        val input = BufferedInputStream(ParcelFileDescriptor.AutoCloseInputStream(from))
        if (title != null || SceneBytes.mayBe(SceneBytes.first(input), name)) return SceneSource.Stream(input, bytes)
        input.close()
        throw SceneSource.Problem(context.getString(R.string.scene_broken))
    }

    override fun wordsFor(problem: IOException): String = context.getString(
        if (problem is FileNotFoundException) R.string.copy_gone else R.string.copy_cut,
    )
}
