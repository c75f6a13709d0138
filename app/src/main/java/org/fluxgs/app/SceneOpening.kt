package org.fluxgs.app

import android.content.ContentResolver
import android.content.Context
import android.net.Uri
import android.os.CancellationSignal
import android.os.Handler
import android.os.Looper
import android.os.ParcelFileDescriptor
import java.io.File
import java.io.FileNotFoundException
import java.io.IOException
import java.util.concurrent.Future
import java.util.concurrent.atomic.AtomicBoolean
import kotlin.concurrent.thread

/**
 * Asks whoever keeps a scene for it, on a thread of its own: other apps may take as long as they like,
 * and throw what they like. onOpened or onFailed is called, on the main thread, unless it is cancelled,
 * onOpened not [before] something else is done and the driver is checked; onSlow, where neither was called
 * for half a minute.
 */
internal class SceneOpening(
    context: Context,
    private val uri: Uri,
    private val onOpened: (descriptor: ParcelFileDescriptor, facts: Scene.Facts) -> Unit,
    private val onFailed: (problem: Problem) -> Unit,
    private val onSlow: () -> Unit,
    private val before: Future<*>? = null,
) {
    private val context = context.applicationContext
    private val main = Handler(Looper.getMainLooper())
    private val over = AtomicBoolean(false)
    private val signal = CancellationSignal() // to the other app

    fun start() {
        thread(name = "scene-opening", isDaemon = true) { open() }
        main.postDelayed(slow, PATIENCE_MS)
    }

    fun cancel() {
        main.removeCallbacks(slow) // which would keep the activity
        if (over.getAndSet(true)) return // answered, or cancelled already
        thread(name = "scene-cancelling", isDaemon = true) { signal.cancel() } // the other app is told
    }

    private val slow = Runnable { if (!over.get()) onSlow() }

    private fun open() {
        var name = ""
        try {
            val facts = Scene.factsOf(context, uri)
            name = facts.name
            val descriptor = descriptorOf(uri)
            before?.get()
            DriverCheck.of(context)
            Session.waitForClosed() // or what it, or a cancelled loading, still has would count as taken
            Native.waitForHeldScenes()
            main.post { finish({ descriptor.close() }) { onOpened(descriptor, facts) } }
        } catch (problem: Exception) {
            main.post { finish { onFailed(problemOf(problem, name)) } }
        }
    }

    private fun finish(otherwise: () -> Unit = {}, callback: () -> Unit) {
        main.removeCallbacks(slow)
        if (over.getAndSet(true)) otherwise() else callback()
    }

    private fun descriptorOf(uri: Uri): ParcelFileDescriptor = when (uri.scheme) {
        "asset" -> ParcelFileDescriptor.open(sample(), ParcelFileDescriptor.MODE_READ_ONLY)
        "file", null -> {
            val path = uri.path ?: throw FileNotFoundException(uri.toString())
            ParcelFileDescriptor.open(File(path), ParcelFileDescriptor.MODE_READ_ONLY)
        }
        else -> context.contentResolver.openFileDescriptor(uri, "r", signal)
            ?: throw FileNotFoundException(uri.toString())
    }

    /** The sample as a file: what lies in an APK has a descriptor that other files share. */
    private fun sample(): File {
        val file = File(context.cacheDir, "sample.glb")
        val version = File(context.cacheDir, "sample.version")
        val wanted = BuildFacts.installed(context)
        if (file.exists() && version.exists() && version.readText() == wanted) return file
        val part = File.createTempFile("sample", null, context.cacheDir)
        context.assets.open("sample.glb").use { from -> part.outputStream().use { from.copyTo(it) } }
        if (!part.renameTo(file)) throw IOException("$file cannot be written")
        version.writeText(wanted)
        return file
    }

    private fun problemOf(problem: Exception, name: String) = Problem(
        context.getString(
            when {
                problem is SecurityException || isForbidden(problem) -> R.string.scene_forbidden
                problem is FileNotFoundException -> R.string.moved_or_deleted
                else -> R.string.scene_unreadable
            },
        ),
        "$uri\n${problem.message ?: problem}", name,
    )

    /** Android says so in words only: "open failed: EACCES (Permission denied)". */
    private fun isForbidden(problem: Exception): Boolean {
        val words = "${problem.message} ${problem.cause?.message}"
        return "EACCES" in words || "EPERM" in words
    }

    companion object {
        const val PATIENCE_MS = 30_000L
    }
}
