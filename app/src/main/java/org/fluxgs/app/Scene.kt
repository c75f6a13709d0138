package org.fluxgs.app

import android.content.ContentResolver
import android.content.Context
import android.database.Cursor
import android.net.Uri
import android.provider.OpenableColumns

/** A scene that can be opened: a document of another app, a file, or the sample of this one. */
internal object Scene {
    val SAMPLE: Uri = Uri.parse("asset:///sample.glb")

    fun isSample(uri: Uri) = uri.scheme == "asset"

    /** A name for people, and how many bytes its keeper says there are; -1 for nobody knows. */
    class Facts(val name: String, val bytes: Long = -1)

    /** May wait for the other app: not for the main thread. */
    fun factsOf(context: Context, uri: Uri): Facts {
        if (isSample(uri)) return Facts(context.getString(R.string.sample_scene))
        val address = Facts(uri.lastPathSegment?.substringAfterLast('/') ?: uri.toString())
        if (uri.scheme != ContentResolver.SCHEME_CONTENT) return address
        return try {
            context.contentResolver.query(uri, null, null, null, null)?.use {
                if (it.moveToFirst()) factsIn(it, address.name) else null
            } ?: address
        } catch (_: RuntimeException) {
            address // other apps may throw anything across
        }
    }

    private fun factsIn(row: Cursor, otherwise: String): Facts {
        val name = row.getColumnIndex(OpenableColumns.DISPLAY_NAME)
        val size = row.getColumnIndex(OpenableColumns.SIZE)
        return Facts(
            if (name >= 0) row.getString(name) ?: otherwise else otherwise,
            if (size >= 0 && !row.isNull(size)) row.getLong(size).coerceAtLeast(-1) else -1,
        )
    }
}
