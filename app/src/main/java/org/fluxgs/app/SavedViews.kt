package org.fluxgs.app

import android.content.Context
import android.net.Uri
import org.json.JSONArray
import org.json.JSONException

/** Views of a scene that people saved, as [Session.place] gives them, in their order. */
internal class SavedViews(context: Context, private val scene: Uri) {
    private val kept = context.getSharedPreferences(FILE, Context.MODE_PRIVATE)

    fun all(): List<DoubleArray> = try {
        val array = JSONArray(kept.getString(scene.toString(), "[]"))
        (0 until array.length()).mapNotNull { placeOf(array.optJSONArray(it)) }
    } catch (_: JSONException) {
        emptyList()
    }

    private fun placeOf(numbers: JSONArray?) = numbers?.takeIf { it.length() == NUMBERS }
        ?.let { array -> DoubleArray(NUMBERS) { array.optDouble(it) } }
        ?.takeIf { place -> place.all { it.isFinite() } }

    /** False where there are [MOST] already. */
    fun add(place: DoubleArray): Boolean {
        val before = all()
        if (before.size >= MOST) return false
        save(before + place)
        return true
    }

    fun remove(index: Int) = save(all().filterIndexed { i, _ -> i != index })

    private fun save(places: List<DoubleArray>) {
        val text = JSONArray(places.map { JSONArray(it.asList()) }).toString()
        val edit = kept.edit()
        if (places.isEmpty()) edit.remove(scene.toString()) else edit.putString(scene.toString(), text)
        edit.apply()
    }

    companion object {
        const val MOST = 100
        private const val FILE = "views"
        private const val NUMBERS = 12

        /** The scene is opened from another place from now on. */
        fun move(context: Context, from: Uri, to: Uri) {
            val kept = context.getSharedPreferences(FILE, Context.MODE_PRIVATE)
            val views = kept.getString(from.toString(), null) ?: return
            kept.edit().putString(to.toString(), views).remove(from.toString()).apply()
        }

        /** Of a scene that is no longer in the list. */
        fun forget(context: Context, scene: Uri) =
            context.getSharedPreferences(FILE, Context.MODE_PRIVATE).edit().remove(scene.toString()).apply()
    }
}
