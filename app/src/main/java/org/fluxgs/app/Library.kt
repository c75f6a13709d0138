package org.fluxgs.app

import android.content.ContentResolver
import android.content.Context
import android.net.Uri
import java.io.File

/**
 * Scenes that the app keeps itself: copies of what other apps have, in its own storage, and files that were
 * sent by adb. Reads and writes files, but for [owns]: for the [Background].
 */
internal class Library(context: Context) {
    val copies = File(context.filesDir, "library")
    private val sent: File? = context.getExternalFilesDir(null) // makes it, for who sends scenes there

    /** True of a file of the app: deleted, it is gone. */
    fun owns(uri: Uri) = uri.scheme == ContentResolver.SCHEME_FILE && File(uri.path ?: "").let { file ->
        file.parentFile == copies || file.parentFile == sent
    }

    /** All that there are, the list of which may have been lost. */
    fun files(): List<File> = listOfNotNull(copies, sent)
        .flatMap { it.listFiles()?.toList() ?: emptyList() }
        .filter { it.isFile && it.extension.lowercase() in Texts.SCENE_ENDINGS }
        .sortedBy { it.name }

    fun delete(uri: Uri): Boolean = owns(uri) && File(uri.path!!).let { it.delete() || !it.exists() }

    /** A file that is not there yet, called as people know the scene. */
    fun newFile(name: String): File {
        copies.mkdirs()
        val ending = Texts.endingOf(name).ifEmpty { ".glb" } // of what is known by what is in it
        val title = Texts.plain(Texts.titleOf(name))
        synchronized(taken) {
            return generateSequence(1) { it + 1 }
                .map { File(copies, if (it == 1) "$title$ending" else "$title ($it)$ending") }
                .first { !it.exists() && it !in taken }
                .also { taken += it }
        }
    }

    /** What copies that were not finished have left, in an earlier process. */
    fun removeParts(running: Collection<File>) = copies.listFiles()
        ?.filter { it.name.endsWith(PART) && it !in running }
        ?.forEach { it.delete() }

    companion object {
        const val PART = ".part"
        private val taken = mutableSetOf<File>() // in this process
    }
}
