package org.fluxgs.app

import android.content.ContentResolver
import android.content.Context
import android.content.Intent
import android.net.Uri

/** Scenes of other apps can be opened again later where those apps allow it. */
internal object UriPermissions {
    private const val READ = Intent.FLAG_GRANT_READ_URI_PERMISSION

    /** Keeps the permission if it is offered: always by the file picker, seldom by "open with" and "share". */
    fun keep(context: Context, uri: Uri) {
        if (uri.scheme != ContentResolver.SCHEME_CONTENT) return
        try {
            context.contentResolver.takePersistableUriPermission(uri, READ)
        } catch (_: SecurityException) {
            // Not every provider lets it be kept; it can be read now
        }
    }

    fun release(context: Context, uri: Uri) {
        try {
            context.contentResolver.releasePersistableUriPermission(uri, READ)
        } catch (_: SecurityException) {
            // There was none
        }
    }

    /**
     * An app may keep a few hundred only: those of scenes that are in no list are let go of, but for
     * new ones, which may be in the list once they have been read.
     */
    fun releaseAllBut(context: Context, wanted: Set<Uri>, now: Long = System.currentTimeMillis()) =
        context.contentResolver.persistedUriPermissions
            .filter { it.uri !in wanted && now - it.persistedTime > NEW_MS }
            .forEach { release(context, it.uri) }

    private const val NEW_MS = 24 * 60 * 60_000L
}
