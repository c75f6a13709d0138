package org.fluxgs.app

import android.annotation.TargetApi
import android.content.ContentValues
import android.content.Context
import android.net.Uri
import android.os.Build
import android.os.Environment
import android.os.ParcelFileDescriptor
import android.provider.MediaStore
import java.io.File
import java.io.IOException

/** A video that is being made: nobody sees it until it is published. Not for the main thread. */
internal class VideoFile private constructor(
    val descriptor: ParcelFileDescriptor,
    private val publishing: () -> Uri,
    private val discarding: () -> Unit,
) {
    /** Closes it and shows it in the gallery; before Android 10 it is a file to share. */
    fun publish(): Uri {
        descriptor.close()
        return publishing()
    }

    /** Closes it and leaves nothing behind. */
    fun discard() {
        try {
            descriptor.close()
        } catch (_: IOException) {
            // of a full disk
        }
        discarding()
    }

    companion object {
        const val TYPE = "video/mp4"

        @Throws(IOException::class)
        fun create(context: Context, scene: String): VideoFile {
            val name = Gallery.fileName(scene, "mp4")
            return try {
                if (Build.VERSION.SDK_INT >= 29) createInGallery(context, name) else createToShare(context, name)
            } catch (problem: RuntimeException) { // of a gallery that takes no video
                throw IOException(problem.message ?: problem.toString(), problem)
            }
        }

        @TargetApi(29)
        private fun createInGallery(context: Context, name: String): VideoFile {
            val resolver = context.contentResolver
            val values = ContentValues().apply {
                put(MediaStore.MediaColumns.DISPLAY_NAME, name)
                put(MediaStore.MediaColumns.MIME_TYPE, TYPE)
                put(MediaStore.MediaColumns.RELATIVE_PATH, Environment.DIRECTORY_MOVIES + "/Flux-GS")
                put(MediaStore.MediaColumns.IS_PENDING, 1)
            }
            val uri = resolver.insert(MediaStore.Video.Media.EXTERNAL_CONTENT_URI, values)
                ?: throw IOException(context.getString(R.string.video_no_gallery))
            val discard = { resolver.delete(uri, null, null); Unit }
            try {
                val descriptor = resolver.openFileDescriptor(uri, "rw") ?: throw IOException(context.getString(R.string.video_no_gallery))
                return VideoFile(descriptor, {
                    resolver.update(uri, ContentValues().apply { put(MediaStore.MediaColumns.IS_PENDING, 0) }, null, null)
                    uri
                }, discard)
            } catch (problem: Exception) {
                discard()
                throw problem
            }
        }

        private fun createToShare(context: Context, name: String): VideoFile {
            val file: File = SharedFiles.create(context, name)
            val mode = ParcelFileDescriptor.MODE_READ_WRITE or ParcelFileDescriptor.MODE_CREATE or
                ParcelFileDescriptor.MODE_TRUNCATE
            return VideoFile(
                ParcelFileDescriptor.open(file, mode), { SharedFiles.uriOf(context, file) }, { file.delete() },
            )
        }
    }
}
