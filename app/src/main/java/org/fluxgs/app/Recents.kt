package org.fluxgs.app

import android.content.Context
import android.graphics.Bitmap
import android.graphics.BitmapFactory
import android.net.Uri
import java.io.File
import java.io.IOException
import org.json.JSONArray
import org.json.JSONException
import org.json.JSONObject

/** A scene that was looked at. */
data class Recent(
    val uri: Uri,
    val name: String,
    val bytes: Long,
    val splats: Long,
    /** The last view of it, see [Session.place]. */
    val place: DoubleArray?,
    /** Names its thumbnail. */
    val id: Long,
) {
    override fun equals(other: Any?) = other is Recent && other.id == id

    override fun hashCode() = id.hashCode()
}

/**
 * The scenes that were opened last, the newest first, with images. Reads and writes files: for the
 * [Background].
 */
internal class Recents(private val context: Context) {
    private val folder = File(context.filesDir, "recents")
    private val list = File(folder, "list.json")

    fun all(): List<Recent> = try {
        val array = JSONArray(list.readText())
        (0 until array.length()).mapNotNull { recentOf(array.optJSONObject(it)) }
    } catch (_: IOException) {
        emptyList()
    } catch (_: JSONException) {
        emptyList()
    }

    fun find(uri: Uri): Recent? = all().find { it.uri == uri }

    /** Puts it first; keeps the image of an earlier time if there is no new one. */
    fun remember(
        uri: Uri, name: String, bytes: Long, splats: Long, place: DoubleArray?, image: Bitmap?,
    ) {
        val before = all()
        val known = before.find { it.uri == uri }
        val id = known?.id ?: ((before.maxOfOrNull { it.id } ?: 0) + 1)
        val entry = Recent(uri, name, bytes, splats, place ?: known?.place, id)
        val kept = listOf(entry) + before.filter { it.uri != uri }
        folder.mkdirs()
        if (image != null) write(thumbnail(id)) { stream ->
            small(image).compress(Bitmap.CompressFormat.JPEG, 85, stream)
        }
        kept.drop(MOST).forEach { thumbnail(it.id).delete() }
        save(kept.take(MOST))
    }

    fun forget(uri: Uri) {
        SavedViews.forget(context, uri)
        val (gone, kept) = all().partition { it.uri == uri }
        gone.forEach { thumbnail(it.id).delete() }
        save(kept)
    }

    fun image(recent: Recent): Bitmap? = BitmapFactory.decodeFile(thumbnail(recent.id).path)

    private fun thumbnail(id: Long) = File(folder, "$id.jpg")

    private fun save(recents: List<Recent>) {
        val array = JSONArray()
        for (recent in recents) array.put(jsonOf(recent))
        folder.mkdirs()
        write(list) { it.write(array.toString().toByteArray()) }
    }

    /** Whole or not at all. A full disk must not end the app: the list is then what it was. */
    private fun write(file: File, content: (java.io.OutputStream) -> Unit) {
        val part = File(file.path + ".part")
        try {
            part.outputStream().use(content)
            part.renameTo(file)
        } catch (_: IOException) {
            part.delete()
        }
    }

    private fun small(image: Bitmap): Bitmap {
        val factor = THUMBNAIL.toFloat() / maxOf(image.width, image.height, THUMBNAIL)
        return Bitmap.createScaledBitmap(
            image,
            (image.width * factor).toInt().coerceAtLeast(1),
            (image.height * factor).toInt().coerceAtLeast(1),
            true,
        )
    }

    private fun jsonOf(recent: Recent) = JSONObject()
        .put("uri", recent.uri.toString())
        .put("name", recent.name)
        .put("bytes", recent.bytes)
        .put("splats", recent.splats)
        .put("place", recent.place?.let { JSONArray(it.toList()) })
        .put("id", recent.id)

    private fun recentOf(json: JSONObject?): Recent? {
        if (json == null || !json.has("uri")) return null
        val numbers = json.optJSONArray("place")
        val place = numbers?.takeIf { it.length() == 12 }
            ?.let { array -> DoubleArray(12) { array.optDouble(it) } }
        return Recent(
            Uri.parse(json.getString("uri")), json.optString("name"), json.optLong("bytes"),
            json.optLong("splats"), place, json.optLong("id"),
        )
    }

    companion object {
        const val MOST = 24
        const val THUMBNAIL = 320
    }
}
