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
 * Files of this app that others may read once they are shared with them: screenshots and results.
 * It gives out what lies directly in [folder] and nothing else.
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
                OpenableColumns.DISPLAY_NAME -> file.name
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
        val name = uri.lastPathSegment ?: throw FileNotFoundException(uri.toString())
        val folder = folder(context!!).canonicalFile
        val file = File(folder, name).canonicalFile
        if (uri.pathSegments.size != 1 || file.parentFile != folder || !file.isFile)
            throw FileNotFoundException(uri.toString())
        return file
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

        fun uriOf(context: Context, file: File): Uri = Uri.Builder()
            .scheme("content")
            .authority(context.packageName + ".shared")
            .appendPath(file.name)
            .build()

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
