package org.fluxgs.app

import android.content.Context
import android.net.Uri
import android.os.CancellationSignal
import android.os.Handler
import android.os.Looper
import java.io.EOFException
import java.io.File
import java.io.FileOutputStream
import java.io.IOException
import java.io.InputStream
import kotlin.concurrent.thread

/**
 * A scene that is being copied into the [Library], on a thread of its own: whole, or nothing of it is left. It
 * goes on when the viewer is left. All but its thread is for the main thread.
 */
internal class SceneCopy private constructor(context: Context, private val from: SceneSource) {
    sealed interface End
    class Kept(val uri: Uri) : End
    class Failed(val message: String) : End
    data object Cancelled : End

    val source get() = from.uri
    val name get() = from.name
    private val context = context.applicationContext
    private val library = Library(context)
    private val signal = CancellationSignal() // to whoever has the scene
    private val listeners = mutableListOf<(End) -> Unit>()

    @Volatile
    private var part: File? = null // of what is copied

    @Volatile
    private var cancelled = false

    @Volatile
    var copied = 0L
        private set

    /** -1 while nobody has said how many there are. */
    @Volatile
    var bytes = -1L
        private set

    fun onEnd(listener: (End) -> Unit) {
        listeners += listener
    }

    fun cancel() {
        cancelled = true
        thread(name = "copy-cancelling", isDaemon = true) { signal.cancel() }
        if (running.remove(source, this)) tell(Cancelled) // also where nobody ever answers
    }

    private fun start() = thread(name = "scene-copy", isDaemon = true) {
        val end = try {
            from.open(signal).let { stream -> stream.input.use { copy(stream) } }
        } catch (problem: SceneSource.Problem) {
            Failed(problem.message!!)
        } catch (_: SecurityException) {
            Failed(context.getString(R.string.scene_forbidden))
        } catch (problem: IOException) {
            Failed(if (isFull(problem)) noRoom() else from.wordsFor(problem))
        } catch (_: RuntimeException) { // other apps may throw anything across
            Failed(context.getString(R.string.copy_gone))
        } finally {
            part?.delete()
        }
        Handler(Looper.getMainLooper()).post { if (running.remove(source, this)) tell(end) }
    }

    private fun tell(end: End) = listeners.forEach { it(end) }

    private fun copy(stream: SceneSource.Stream): End {
        bytes = stream.bytes
        val target = library.newFile(name)
        if (bytes > library.copies.usableSpace - RESERVE) throw SceneSource.Problem(noRoom())
        val file = File(target.path + Library.PART).also { part = it }
        read(stream.input, file)
        if (cancelled) return Cancelled
        if (copied < bytes) throw EOFException("$copied of $bytes bytes")
        if (!file.renameTo(target)) throw IOException("$file")
        val uri = Uri.fromFile(target)
        Background.start { Recents(context).keep(source, uri, name, copied) }.get()
        return Kept(uri)
    }

    private fun read(input: InputStream, file: File) = FileOutputStream(file).use { to ->
        val buffer = ByteArray(CHUNK)
        while (!cancelled) {
            val got = input.read(buffer)
            if (got < 0) break
            to.write(buffer, 0, got)
            copied += got
            if (bytes in 0 until copied) throw SceneSource.Problem(context.getString(R.string.copy_grows))
            if (library.copies.usableSpace < RESERVE) throw SceneSource.Problem(noRoom())
        }
        to.fd.sync()
    }

    private fun noRoom() = context.getString(
        R.string.copy_no_room, Texts.size(context, maxOf(bytes, copied)),
        Texts.size(context, (library.copies.usableSpace + (part?.length() ?: 0) - RESERVE).coerceAtLeast(0)),
    )

    private fun isFull(problem: IOException) =
        "ENOSPC" in "${problem.message} ${problem.cause?.message}" || "No space" in "${problem.message}"

    companion object {
        private const val CHUNK = 256 * 1024
        const val RESERVE = 64L shl 20 // bytes of storage that are left to others
        private val running = java.util.concurrent.ConcurrentHashMap<Uri, SceneCopy>()

        /** The copy of this scene that is being made. */
        fun of(source: Uri): SceneCopy? = running[source]

        val isAny get() = running.isNotEmpty()

        fun start(context: Context, from: SceneSource): SceneCopy = running[from.uri]
            ?: SceneCopy(context, from).also {
                running[from.uri] = it
                it.start()
            }

        /** Of a scene that was looked at, called so. */
        fun start(context: Context, source: Uri, name: String) =
            start(context, Document(context.applicationContext, source, name))

        fun removeOldParts(library: Library) = library.removeParts(running.values.mapNotNull { it.part })
    }
}
