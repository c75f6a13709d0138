package org.fluxgs.app

import android.annotation.TargetApi
import android.content.ContentValues
import android.content.Context
import android.graphics.Bitmap
import android.net.Uri
import android.os.Build
import android.os.Environment
import android.provider.MediaStore
import java.io.File
import java.io.IOException
import java.text.SimpleDateFormat
import java.util.Date
import java.util.Locale

/** Saves screenshots to the gallery. */
internal object Gallery {
    /** The image in the gallery; before Android 10, which asks for a permission, in a file to share. */
    @Throws(IOException::class)
    fun save(context: Context, image: Bitmap, name: String): Uri {
        val file = fileName(name, "png")
        return try {
            if (Build.VERSION.SDK_INT >= 29) save29(context, image, file)
            else saveToShare(context, image, file)
        } catch (problem: RuntimeException) { // of a gallery that takes no image, or not ours
            throw IOException(problem.message ?: problem.toString(), problem)
        }
    }

    fun fileName(scene: String, ending: String): String {
        val time = SimpleDateFormat("yyyy-MM-dd HH.mm.ss", Locale.ROOT).format(Date())
        return "${Texts.plain(Texts.titleOf(scene))} $time.$ending"
    }

    @TargetApi(29)
    private fun save29(context: Context, image: Bitmap, file: String): Uri {
        val resolver = context.contentResolver
        val values = ContentValues().apply {
            put(MediaStore.Images.Media.DISPLAY_NAME, file)
            put(MediaStore.Images.Media.MIME_TYPE, "image/png")
            put(MediaStore.Images.Media.RELATIVE_PATH, Environment.DIRECTORY_PICTURES + "/Flux-GS")
            put(MediaStore.Images.Media.IS_PENDING, 1)
        }
        val uri = resolver.insert(MediaStore.Images.Media.EXTERNAL_CONTENT_URI, values)
            ?: throw IOException(context.getString(R.string.gallery_refuses))
        try {
            resolver.openOutputStream(uri)?.use { compress(context, image, it) }
                ?: throw IOException(context.getString(R.string.gallery_refuses))
        } catch (problem: Exception) {
            resolver.delete(uri, null, null)
            throw problem
        }
        values.clear()
        values.put(MediaStore.Images.Media.IS_PENDING, 0)
        resolver.update(uri, values, null, null)
        return uri
    }

    private fun saveToShare(context: Context, image: Bitmap, file: String): Uri {
        val target = SharedFiles.create(context, file)
        target.outputStream().use { compress(context, image, it) }
        return SharedFiles.uriOf(context, target)
    }

    private fun compress(context: Context, image: Bitmap, stream: java.io.OutputStream) {
        if (!image.compress(Bitmap.CompressFormat.PNG, 100, stream))
            throw IOException(context.getString(R.string.storage_refuses))
    }
}
