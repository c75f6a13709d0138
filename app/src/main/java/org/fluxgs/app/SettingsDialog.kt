package org.fluxgs.app

import android.app.Activity
import android.app.AlertDialog
import android.view.View
import android.widget.AdapterView
import android.widget.ArrayAdapter
import android.widget.Spinner
import android.widget.Switch

/** The settings over a scene: each change is seen at once. */
internal class SettingsDialog(
    private val activity: Activity,
    private var settings: Settings,
    private val onChange: (Settings) -> Unit,
    private val onFlip: () -> Unit,
) {
    fun show(): AlertDialog {
        val view = activity.layoutInflater.inflate(R.layout.settings, null)
        choice(view, R.id.scale, scaleNames(), Settings.SCALES.indexOfFirst { it == settings.scale }) {
            settings.copy(scale = Settings.SCALES[it])
        }
        choice(view, R.id.sorter, names(R.array.sorters), settings.sorter) {
            settings.copy(sorter = it)
        }
        choice(view, R.id.degree, names(R.array.degrees), settings.shDegree) {
            settings.copy(shDegree = it)
        }
        choice(view, R.id.budget, budgetNames(), Settings.BUDGETS.indexOf(settings.maxSplats)) {
            settings.copy(maxSplats = Settings.BUDGETS[it])
        }
        val hud = view.findViewById<Switch>(R.id.hud)
        hud.isChecked = settings.hud
        hud.setOnCheckedChangeListener { _, on -> change(settings.copy(hud = on)) }
        view.findViewById<View>(R.id.flip).setOnClickListener { onFlip() }
        return AlertDialog.Builder(activity)
            .setTitle(R.string.settings)
            .setView(view)
            .setPositiveButton(android.R.string.ok, null)
            .show()
    }

    private fun names(array: Int) = activity.resources.getStringArray(array).toList()

    private fun scaleNames() = Settings.SCALES.map {
        if (it == 0f) activity.getString(R.string.automatic) else "${(100 * it).toInt()}%"
    }

    private fun budgetNames() = Settings.BUDGETS.map {
        if (it == 0) activity.getString(R.string.all_splats) else Texts.count(it.toLong())
    }

    private fun choice(
        view: View, id: Int, names: List<String>, chosen: Int, with: (Int) -> Settings,
    ) {
        val spinner = view.findViewById<Spinner>(id)
        val adapter = ArrayAdapter(activity, android.R.layout.simple_spinner_item, names)
        adapter.setDropDownViewResource(android.R.layout.simple_spinner_dropdown_item)
        spinner.adapter = adapter
        spinner.setSelection(chosen.coerceAtLeast(0), false)
        spinner.onItemSelectedListener = object : AdapterView.OnItemSelectedListener {
            override fun onItemSelected(list: AdapterView<*>?, row: View?, at: Int, id: Long) =
                change(with(at))

            override fun onNothingSelected(list: AdapterView<*>?) = Unit
        }
    }

    private fun change(changed: Settings) {
        if (changed == settings) return
        settings = changed
        changed.save(activity)
        onChange(changed)
    }
}
