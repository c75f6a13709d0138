package org.fluxgs.app

import android.content.Context
import android.net.Uri
import android.os.CancellationSignal
import android.os.Handler
import android.os.Looper
import android.os.ParcelFileDescriptor
import java.io.File
import java.io.FileNotFoundException
import java.io.FileOutputStream
import java.io.IOException
import java.io.InputStream
import kotlin.concurrent.thread

/**
 * A scene of another app that is being copied into the [Library], on a thread of its own: whole, or nothing
 * of it is left. It goes on when the viewer is left. All but its thread is for the main thread.
 */
internal class SceneCopy private constructor(context: Context, val source: Uri, private val name: String) {
    sealed interface End
    class Kept(val uri: Uri) : End
    class Failed(val message: String) : End
    data object Cancelled : End

    /** What it was stopped by, in words for people. */
    private class Problem(message: String) : IOException(message)

    private val context = context.applicationContext
    private val library = Library(context)
    private val target = library.newFile(name)
    private val part = File(target.path + Library.PART)
    private val signal = CancellationSignal() // to the other app
    private val listeners = mutableListOf<(End) -> Unit>()

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
        if (running.remove(source, this)) tell(Cancelled) // also where the other app never answers
    }

    private fun start() = thread(name = "scene-copy", isDaemon = true) {
        val end = try {
            copy()
            keep()
        } catch (problem: Problem) {
            Failed(problem.message!!)
        } catch (_: FileNotFoundException) {
            Failed(context.getString(R.string.copy_gone))
        } catch (_: SecurityException) {
            Failed(context.getString(R.string.scene_forbidden))
        } catch (problem: IOException) {
            Failed(if (isFull(problem)) noRoom() else context.getString(R.string.copy_cut))
        } catch (_: RuntimeException) { // other apps may throw anything across
            Failed(context.getString(R.string.copy_gone))
        } finally {
            part.delete()
        }
        Handler(Looper.getMainLooper()).post { if (running.remove(source, this)) tell(end) }
    }

    private fun tell(end: End) = listeners.forEach { it(end) }

    private fun copy() {
        val from = context.contentResolver.openFileDescriptor(source, "r", signal)
            ?: throw FileNotFoundException(source.toString())
        from.use {
            bytes = sizeOf(from)
            if (bytes > library.copies.usableSpace - RESERVE) throw Problem(noRoom())
            ParcelFileDescriptor.AutoCloseInputStream(from).use { read(it) }
            if (cancelled) return
            if (bytes >= 0 && copied < bytes) throw Problem(context.getString(R.string.copy_cut))
        }
    }

    /** By its own word, or for a pipe by that of the other app. */
    private fun sizeOf(from: ParcelFileDescriptor) =
        if (from.statSize > 0) from.statSize else Scene.factsOf(context, source).bytes

    private fun read(from: InputStream) = FileOutputStream(part).use { to ->
        val buffer = ByteArray(CHUNK)
        while (!cancelled) {
            val got = from.read(buffer)
            if (got < 0) break
            to.write(buffer, 0, got)
            copied += got
            if (bytes in 0 until copied) throw Problem(context.getString(R.string.copy_grows))
            if (library.copies.usableSpace < RESERVE) throw Problem(noRoom())
        }
        to.fd.sync()
    }

    private fun keep(): End {
        if (cancelled) return Cancelled
        if (!part.renameTo(target)) throw IOException("$part")
        val uri = Uri.fromFile(target)
        Background.start { Recents(context).keep(source, uri, name, copied) }.get()
        return Kept(uri)
    }

    private fun noRoom() = context.getString(
        R.string.copy_no_room, Texts.size(context, maxOf(bytes, copied)),
        Texts.size(context, (library.copies.usableSpace + part.length() - RESERVE).coerceAtLeast(0)),
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

        fun start(context: Context, source: Uri, name: String): SceneCopy = running[source]
            ?: SceneCopy(context, source, name).also {
                running[source] = it
                it.start()
            }

        fun removeOldParts(library: Library) = library.removeParts(running.values.map { it.part })
    }
}
