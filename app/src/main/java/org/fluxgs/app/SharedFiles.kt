package org.fluxgs.app

import android.content.ContentProvider
import android.content.ContentValues
import android.content.Context
import android.content.Intent
import android.database.Cursor
import android.database.MatrixCursor
import android.net.Uri
import android.os.ParcelFileDescriptor
import android.provider.OpenableColumns
import java.io.File
import java.io.FileNotFoundException

/**
 * Files of this app that others may read once they are shared with them: screenshots and results, and the
 * scenes of the [Library]. It gives out what lies directly in one of these folders and nothing else.
 */
class SharedFiles : ContentProvider() {
    override fun onCreate() = true

    override fun openFile(uri: Uri, mode: String): ParcelFileDescriptor {
        if (mode != "r") throw SecurityException("read only")
        return ParcelFileDescriptor.open(fileOf(uri), ParcelFileDescriptor.MODE_READ_ONLY)
    }

    override fun getType(uri: Uri) = when (uri.lastPathSegment?.substringAfterLast('.')) {
        "png" -> "image/png"
        "mp4" -> VideoFile.TYPE
        "json" -> "application/json"
        "csv" -> "text/csv"
        "glb" -> "model/gltf-binary"
        else -> "application/octet-stream"
    }

    override fun query(
        uri: Uri, columns: Array<String>?, selection: String?, arguments: Array<String>?,
        order: String?,
    ): Cursor {
        val file = fileOf(uri)
        val wanted = columns ?: arrayOf(OpenableColumns.DISPLAY_NAME, OpenableColumns.SIZE)
        val cursor = MatrixCursor(wanted, 1)
        cursor.addRow(wanted.map {
            when (it) {
                OpenableColumns.DISPLAY_NAME -> nameOf(file)
                OpenableColumns.SIZE -> file.length()
                else -> null
            }
        })
        return cursor
    }

    override fun insert(uri: Uri, values: ContentValues?): Uri? = null

    override fun delete(uri: Uri, selection: String?, arguments: Array<String>?) = 0

    override fun update(
        uri: Uri, values: ContentValues?, selection: String?, arguments: Array<String>?,
    ) = 0

    private fun fileOf(uri: Uri): File {
        val path = uri.pathSegments
        val folder = foldersOf(context!!)[path.dropLast(1)]?.canonicalFile
        val file = path.lastOrNull()?.let { name -> folder?.let { File(it, name).canonicalFile } }
        if (file == null || file.parentFile != folder || !file.isFile) throw FileNotFoundException(uri.toString())
        return file
    }

    /** A scene's is what people call it. */
    private fun nameOf(file: File): String {
        val known = Recents(context!!).find(Uri.fromFile(file)) ?: return file.name
        return Texts.plain(Texts.titleOf(known.name)) + Texts.endingOf(file.name)
    }

    companion object {
        fun folder(context: Context) = File(context.filesDir, "shared").apply { mkdirs() }

        /** A file to share. Who was given an earlier one has had days to read it. */
        fun create(context: Context, name: String): File {
            val old = System.currentTimeMillis() - KEPT_MS
            folder(context).listFiles()?.filter { it.lastModified() < old }?.forEach { it.delete() }
            return File(folder(context), name)
        }

        private const val KEPT_MS = 3L * 24 * 3600 * 1000

        /** By the paths that others know them by. */
        private fun foldersOf(context: Context): Map<List<String>, File> = listOfNotNull(
            emptyList<String>() to folder(context),
            listOf("library") to Library(context).copies,
            context.getExternalFilesDir(null)?.let { listOf("sent") to it },
        ).toMap()

        /** Of a file in one of the folders. */
        fun uriOf(context: Context, file: File): Uri {
            val path = foldersOf(context).entries.first { it.value == file.parentFile }.key
            return (path + file.name).fold(
                Uri.Builder().scheme("content").authority(context.packageName + ".shared"),
            ) { uri, part -> uri.appendPath(part) }.build()
        }

        /** An intent with which people choose who gets a file. */
        fun send(context: Context, uri: Uri, type: String): Intent = Intent.createChooser(
            Intent(Intent.ACTION_SEND)
                .setType(type)
                .putExtra(Intent.EXTRA_STREAM, uri)
                .addFlags(Intent.FLAG_GRANT_READ_URI_PERMISSION),
            null,
        )
    }
}
