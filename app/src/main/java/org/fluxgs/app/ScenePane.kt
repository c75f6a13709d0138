package org.fluxgs.app

import android.app.Activity
import android.view.View
import android.view.ViewGroup
import android.widget.Button
import android.widget.ImageView
import android.widget.TextView

/** Beside the list, where there is room: the scene that is selected, and what can be done with it. */
internal class ScenePane(
    private val activity: Activity, private val root: View, private val menu: SceneMenu, onOpen: (Recent) -> Unit,
) {
    private val recents = Recents(activity)
    private val image = root.findViewById<ImageView>(R.id.pane_image)
    private val choices = root.findViewById<ViewGroup>(R.id.pane_choices)
    private var shown: Recent? = null

    init {
        image.clipToOutline = true
        for (view in listOf<View>(image, root.findViewById(R.id.pane_open)))
            view.setOnClickListener { shown?.let(onOpen) }
    }

    fun show(entry: SceneEntry) {
        val recent = entry.recent
        if (shown != recent || entry.image == null) image.setImageBitmap(entry.image)
        shown = recent
        root.findViewById<TextView>(R.id.pane_name).text = SceneCards.nameOf(activity, recent)
        root.findViewById<TextView>(R.id.pane_facts).text = menu.factsOf(recent)
        choices.removeViews(1, choices.childCount - 1) // all but that which opens it
        for (choice in menu.choices(recent, image).filter { it.itemId != R.id.details }) {
            val button = activity.layoutInflater.inflate(R.layout.choice, choices, false) as Button
            button.text = choice.title
            button.setOnClickListener { menu.choose(choice.itemId, recent) }
            choices.addView(button)
        }
        Background.start {
            val picture = recents.picture(recent) ?: return@start
            activity.runOnUiThread { if (shown == recent) image.setImageBitmap(picture) }
        }
    }
}
