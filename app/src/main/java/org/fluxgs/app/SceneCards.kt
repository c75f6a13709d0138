package org.fluxgs.app

import android.content.Context
import android.graphics.Bitmap
import android.graphics.BitmapFactory
import android.net.Uri
import android.view.LayoutInflater
import android.view.View
import android.view.ViewGroup
import android.widget.BaseAdapter
import android.widget.ImageView
import android.widget.TextView
import java.text.Collator

/** A scene in the list, with its image if it was looked at. */
internal class SceneEntry(val recent: Recent, val image: Bitmap?)

/** The cards of the list of scenes: the sample, and then the others in the order that is chosen. */
internal class SceneCards(
    private val context: Context,
    private val onMenu: (recent: Recent, button: View) -> Unit,
) : BaseAdapter() {
    private val fresh by lazy { SceneEntry(sampleOf(context), pictureOfSample(context)) }
    private var sample = fresh
    private var others = emptyList<SceneEntry>()

    fun show(entries: List<SceneEntry>, order: SceneOrder) {
        val (samples, rest) = entries.partition { Scene.isSample(it.recent.uri) }
        sample = samples.firstOrNull()?.let { SceneEntry(it.recent, it.image ?: fresh.image) } ?: fresh
        others = sorted(rest, order)
        notifyDataSetChanged()
    }

    fun recentAt(position: Int): Recent = entryAt(position).recent

    /** -1 for none. */
    fun positionOf(uri: Uri) = (0 until count).firstOrNull { recentAt(it).uri == uri } ?: -1

    override fun getCount() = others.size + 1

    override fun getItem(position: Int): Any = recentAt(position).uri

    /** The grid also asks for what was selected before the device was turned, while the list is not read yet. */
    override fun getItemId(position: Int) = others.getOrNull(position - 1)?.recent?.id ?: 0L

    override fun hasStableIds() = true

    override fun getView(position: Int, old: View?, parent: ViewGroup): View {
        val view = old ?: LayoutInflater.from(context).inflate(R.layout.scene, parent, false)
            .apply { clipToOutline = true }
        val entry = entryAt(position)
        val name = nameOf(context, entry.recent)
        val detail = detailOf(entry.recent)
        view.findViewById<TextView>(R.id.name).text = name
        view.findViewById<TextView>(R.id.detail).text = detail
        view.findViewById<ImageView>(R.id.image).setImageBitmap(entry.image)
        view.contentDescription = "$name, $detail"
        view.findViewById<View>(R.id.menu).apply {
            contentDescription = context.getString(R.string.more_of, name)
            setOnClickListener { onMenu(entry.recent, it) }
        }
        return view
    }

    fun entryAt(position: Int) = if (position == 0) sample else others[position - 1]

    private fun detailOf(recent: Recent): String {
        SceneCopy.of(recent.uri)?.let { return progressOf(context, it) }
        if (recent.bytes == 0L) return context.getString(R.string.sample_detail)
        return listOfNotNull(
            recent.splats.takeIf { it > 0 }?.let { Texts.splats(context, it, Texts::short) },
            Texts.size(context, recent.bytes),
            recent.opened.takeIf { it > 0 }?.let { Texts.day(it) },
        ).joinToString(" · ")
    }

    companion object {
        private fun sampleOf(context: Context) =
            Recent(Scene.SAMPLE, context.getString(R.string.sample_scene), 0, 0, null, 0)

        /** While it was not opened: what the driver's check compares with. */
        private fun pictureOfSample(context: Context): Bitmap? =
            context.assets.open("sample.webp").use(BitmapFactory::decodeStream)

        fun nameOf(context: Context, recent: Recent) =
            if (Scene.isSample(recent.uri)) context.getString(R.string.sample_scene)
            else Texts.titleOf(recent.name)

        fun progressOf(context: Context, copy: SceneCopy): String =
            context.getString(R.string.copying, sizeOf(context, copy))

        /** "1.0 MB of 7.2 MB" */
        fun sizeOf(context: Context, copy: SceneCopy): String =
            if (copy.bytes < 0) Texts.size(context, copy.copied)
            else context.getString(
                R.string.read_of, Texts.size(context, copy.copied), Texts.size(context, copy.bytes),
            )

        private fun sorted(entries: List<SceneEntry>, order: SceneOrder) = when (order) {
            SceneOrder.OPENED -> entries.sortedByDescending { it.recent.opened }
            SceneOrder.NAME -> {
                val collator = Collator.getInstance()
                entries.sortedWith { a, b -> collator.compare(a.recent.name, b.recent.name) }
            }
            SceneOrder.SIZE -> entries.sortedByDescending { it.recent.bytes }
        }
    }
}
