package org.fluxgs.app

import android.content.ContentResolver
import android.content.Context
import android.net.Uri
import android.provider.OpenableColumns

/** A scene that can be opened: a document of another app, a file, or the sample of this one. */
internal object Scene {
    val SAMPLE: Uri = Uri.parse("asset:///sample.glb")

    fun isSample(uri: Uri) = uri.scheme == "asset"

    /** For people. May wait for the other app: not for the main thread. */
    fun nameOf(context: Context, uri: Uri): String {
        if (isSample(uri)) return context.getString(R.string.sample_scene)
        if (uri.scheme == ContentResolver.SCHEME_CONTENT) {
            try {
                val columns = arrayOf(OpenableColumns.DISPLAY_NAME)
                context.contentResolver.query(uri, columns, null, null, null)?.use {
                    if (it.moveToFirst()) it.getString(0)?.let { name -> return name }
                }
            } catch (_: RuntimeException) {
                // Other apps may throw anything across; the address has a name, too
            }
        }
        return uri.lastPathSegment?.substringAfterLast('/') ?: uri.toString()
    }
}
