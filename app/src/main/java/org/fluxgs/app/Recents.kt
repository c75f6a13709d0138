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
    /** When it was looked at, ms since 1970; 0: not known. */
    val opened: Long = 0,
    /** Where the app has copied it from. */
    val source: Uri? = null,
    /** The name was given here. */
    val named: Boolean = false,
    /** No copy of it is wanted. */
    val declined: Boolean = false,
) {
    override fun equals(other: Any?) = other is Recent && other.id == id

    override fun hashCode() = id.hashCode()
}

/** In which order people want to see their scenes. */
internal enum class SceneOrder { OPENED, NAME, SIZE }

/**
 * The scenes that were opened last, the newest first, with images: those of the [Library], and a few of other
 * apps. Reads and writes files: for the [Background].
 */
internal class Recents(private val context: Context) {
    private val library = Library(context)
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

    /** By where it is, or was copied from. */
    fun find(uri: Uri): Recent? = all().let { all ->
        all.find { it.uri == uri } ?: all.find { it.source == uri }
    }

    /**
     * Puts it first; keeps the image of an earlier time if there is no new one. What there is a copy of is
     * remembered as that. A file that was deleted meanwhile does not come back into the list.
     */
    fun remember(
        uri: Uri, name: String, bytes: Long, splats: Long, place: DoubleArray?, image: Bitmap?,
    ) {
        if (library.owns(uri) && !File(uri.path!!).exists()) return forget(uri)
        val before = all()
        val known = before.find { it.uri == uri } ?: before.find { it.source == uri && it.bytes == bytes }
        val id = known?.id ?: newId(before)
        val entry = Recent(
            known?.uri ?: uri, known?.takeIf { it.named }?.name ?: name, bytes, splats, place ?: known?.place, id,
            System.currentTimeMillis(), known?.source, known?.named ?: false, known?.declined ?: false,
        )
        folder.mkdirs()
        if (image != null) write(thumbnail(id)) { stream ->
            small(image).compress(Bitmap.CompressFormat.JPEG, 85, stream)
        }
        saveNewest(listOf(entry) + before.filter { it.id != id })
    }

    /** Those of other apps are dropped where there are many; what the app keeps itself never is. */
    private fun saveNewest(recents: List<Recent>) {
        val others = recents.filter { !library.owns(it.uri) && !Scene.isSample(it.uri) }
        val dropped = others.drop(MOST).toSet()
        dropped.forEach { thumbnail(it.id).delete() }
        save(recents.filter { it !in dropped })
    }

    private fun newId(known: List<Recent>) = (known.maxOfOrNull { it.id } ?: 0) + 1

    /** The scene was copied: from now on it is there that it is opened from. */
    fun keep(source: Uri, copy: Uri, name: String, bytes: Long) {
        val before = all()
        val known = before.find { it.uri == source }
            ?: Recent(source, name, bytes, 0, null, newId(before), System.currentTimeMillis())
        SavedViews.move(context, source, copy)
        val kept = known.copy(uri = copy, bytes = bytes, source = source, named = true)
        save(if (known in before) before.map { if (it == known) kept else it } else listOf(kept) + before)
    }

    /** Nobody is asked again whether a copy of it is wanted. */
    fun decline(uri: Uri) = save(all().map { if (it.uri == uri) it.copy(declined = true) else it })

    /** [recent] may be a file that was never opened. */
    fun rename(recent: Recent, name: String) {
        val before = all()
        val renamed = recent.copy(name = name, named = true)
        if (before.any { it.uri == recent.uri })
            save(before.map { if (it.uri == recent.uri) it.copy(name = name, named = true) else it })
        else save(before + renamed.copy(id = newId(before)))
    }

    fun forget(uri: Uri) {
        SavedViews.forget(context, uri)
        val (gone, kept) = all().partition { it.uri == uri }
        if (gone.isEmpty()) return
        gone.forEach { thumbnail(it.id).delete() }
        save(kept)
    }

    /** For a list. */
    fun image(recent: Recent): Bitmap? {
        val file = thumbnail(recent.id).path
        val options = BitmapFactory.Options().apply { inJustDecodeBounds = true }
        BitmapFactory.decodeFile(file, options)
        options.inSampleSize = maxOf(options.outWidth, options.outHeight) / SMALL
        options.inJustDecodeBounds = false
        return BitmapFactory.decodeFile(file, options)
    }

    /** As it is kept, up to [PICTURE] pixels. */
    fun picture(recent: Recent): Bitmap? = BitmapFactory.decodeFile(thumbnail(recent.id).path)

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
        val factor = PICTURE.toFloat() / maxOf(image.width, image.height, PICTURE)
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
        .put("opened", recent.opened)
        .put("source", recent.source?.toString())
        .put("named", recent.named)
        .put("declined", recent.declined)

    private fun recentOf(json: JSONObject?): Recent? {
        if (json == null || !json.has("uri")) return null
        val numbers = json.optJSONArray("place")
        val place = numbers?.takeIf { it.length() == 12 }
            ?.let { array -> DoubleArray(12) { array.optDouble(it) } }
        return Recent(
            Uri.parse(json.getString("uri")), json.optString("name"), json.optLong("bytes"),
            json.optLong("splats"), place, json.optLong("id"), json.optLong("opened"),
            json.optString("source").ifEmpty { null }?.let { Uri.parse(it) },
            json.optBoolean("named"), json.optBoolean("declined"),
        )
    }

    companion object {
        const val MOST = 24
        const val PICTURE = 960
        private const val SMALL = 320
    }
}
