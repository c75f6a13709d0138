package org.fluxgs.app

import android.app.Activity
import android.app.Dialog
import android.text.SpannableStringBuilder
import android.text.Spanned
import android.text.style.ForegroundColorSpan
import android.text.style.RelativeSizeSpan
import android.view.Gravity
import android.view.View
import android.view.ViewGroup
import android.widget.AdapterView
import android.widget.ArrayAdapter
import android.widget.CheckBox
import android.widget.RadioButton
import android.widget.RadioGroup
import android.widget.Spinner
import java.text.NumberFormat
import kotlin.math.min

/** The quality, chosen at the edge of the screen: above it the scene shows what each choice does. */
internal class QualitySheet(
    private val activity: Activity,
    private var settings: Settings,
    private val onChange: (Settings) -> Unit,
) {
    private val dialog = Dialog(activity, R.style.Sheet)
    private val view = activity.layoutInflater.inflate(R.layout.quality, null)
    private val qualities = view.findViewById<RadioGroup>(R.id.qualities)
    private var filling = false // the choices follow the settings, not people

    fun show() {
        for (quality in Quality.entries)
            view.findViewById<RadioButton>(quality.choice).text = textOf(quality)
        qualities.setOnCheckedChangeListener { _, id ->
            val chosen = Quality.entries.find { it.choice == id }
            if (chosen != null && !filling) change(chosen.of(settings))
        }
        unfoldByCheck()
        fill()
        dialog.setTitle(R.string.quality) // which is read out
        dialog.setContentView(view)
        dialog.show()
        place()
    }

    private fun textOf(quality: Quality): CharSequence {
        val text = SpannableStringBuilder(activity.getString(quality.label)).append('\n')
        val from = text.length
        text.append(activity.getString(quality.line))
        for (look in listOf(RelativeSizeSpan(0.8f), ForegroundColorSpan(activity.getColor(R.color.dim))))
            text.setSpan(look, from, text.length, Spanned.SPAN_EXCLUSIVE_EXCLUSIVE)
        return text
    }

    private fun unfoldByCheck() {
        val advanced = view.findViewById<View>(R.id.advanced_settings)
        view.findViewById<CheckBox>(R.id.advanced).setOnCheckedChangeListener { _, on ->
            advanced.visibility = if (on) View.VISIBLE else View.GONE
            place()
        }
    }

    /** At the bottom, or beside the scene where the screen is low; never over more than half of it. */
    private fun place() {
        val window = dialog.window ?: return
        val metrics = activity.resources.displayMetrics
        val low = metrics.widthPixels > metrics.heightPixels
        val widest = ((if (low) LOW_WIDTH_DP else WIDTH_DP) * metrics.density).toInt()
        window.setGravity(if (low) Gravity.BOTTOM or Gravity.END else Gravity.BOTTOM)
        val unfolded = view.findViewById<CheckBox>(R.id.advanced).isChecked
        window.setLayout(
            min(widest, metrics.widthPixels),
            if (unfolded && !low) metrics.heightPixels / 2 else ViewGroup.LayoutParams.WRAP_CONTENT,
        )
        Insets.immersive(window)
    }

    /** All choices as the settings are. */
    private fun fill() {
        filling = true
        val quality = Quality.ofSettings(settings)
        if (quality == null) qualities.clearCheck() else qualities.check(quality.choice)
        choice(R.id.scale, scaleNames(), Settings.SCALES.indexOfFirst { it == settings.scale }) {
            settings.copy(scale = Settings.SCALES[it])
        }
        choice(R.id.sorter, names(R.array.sorters), settings.sorter) { settings.copy(sorter = it) }
        choice(R.id.degree, names(R.array.degrees), settings.shDegree) { settings.copy(shDegree = it) }
        choice(R.id.budget, budgetNames(), Settings.BUDGETS.indexOf(settings.maxSplats)) {
            settings.copy(maxSplats = Settings.BUDGETS[it])
        }
        filling = false
    }

    private fun names(array: Int) = activity.resources.getStringArray(array).toList()

    private fun scaleNames() = Settings.SCALES.map {
        if (it == 0f) activity.getString(R.string.automatic)
        else NumberFormat.getPercentInstance().format(it)
    }

    private fun budgetNames() = Settings.BUDGETS.map {
        if (it == 0) activity.getString(R.string.all_splats) else Texts.count(it.toLong())
    }

    private fun choice(id: Int, names: List<String>, chosen: Int, with: (Int) -> Settings) {
        val spinner = view.findViewById<Spinner>(id)
        if (spinner.adapter == null) {
            val adapter = ArrayAdapter(activity, android.R.layout.simple_spinner_item, names)
            adapter.setDropDownViewResource(android.R.layout.simple_spinner_dropdown_item)
            spinner.adapter = adapter
        }
        spinner.setSelection(chosen.coerceAtLeast(0), false)
        if (spinner.onItemSelectedListener != null) return
        spinner.onItemSelectedListener = object : AdapterView.OnItemSelectedListener {
            override fun onItemSelected(list: AdapterView<*>?, row: View?, at: Int, id: Long) =
                change(with(at))

            override fun onNothingSelected(list: AdapterView<*>?) = Unit
        }
    }

    private fun change(changed: Settings) {
        if (changed == settings) return
        settings = changed
        fill()
        onChange(changed)
    }

    private companion object {
        const val WIDTH_DP = 560
        const val LOW_WIDTH_DP = 340
    }
}
