package org.fluxgs.app

import android.app.Activity
import android.app.AlertDialog
import android.content.ContentResolver
import android.content.Intent
import android.net.Uri
import android.text.InputType
import android.view.Menu
import android.view.MenuItem
import android.view.View
import android.widget.EditText
import android.widget.FrameLayout
import android.widget.PopupMenu
import android.widget.Toast
import java.io.File
import java.io.IOException
import java.text.DateFormat
import java.util.Date

/** What can be done with a scene of the list. onChange is called once the list is another. */
internal class SceneMenu(private val activity: Activity, private val onChange: () -> Unit) {
    private val recents = Recents(activity)
    private val library = Library(activity)

    fun show(recent: Recent, button: View) {
        val popup = popupOf(recent, button)
        popup.setOnMenuItemClickListener {
            choose(it.itemId, recent)
            true
        }
        popup.show()
    }

    private fun popupOf(recent: Recent, beside: View) = PopupMenu(activity, beside).apply {
        inflate(R.menu.scene)
        offer(menu, recent)
    }

    fun choices(recent: Recent, beside: View): List<MenuItem> = popupOf(recent, beside).menu.let { menu ->
        (0 until menu.size()).map { menu.getItem(it) }.filter { it.isVisible }
    }

    private fun offer(menu: Menu, recent: Recent) {
        val sample = Scene.isSample(recent.uri)
        val own = library.owns(recent.uri)
        val copies = SceneCopy.of(recent.uri) != null
        val foreign = recent.uri.scheme == ContentResolver.SCHEME_CONTENT
        for ((id, there) in listOf(
            R.id.keep_copy to (foreign && !copies), R.id.stop_copy to copies, R.id.rename to !sample,
            R.id.forget to (!sample && !own), R.id.delete to own,
        )) menu.findItem(id).isVisible = there
    }

    fun choose(id: Int, recent: Recent) {
        when (id) {
            R.id.keep_copy -> keepCopy(recent)
            R.id.stop_copy -> SceneCopy.of(recent.uri)?.cancel()
            R.id.rename -> askForName(recent)
            R.id.share -> share(recent)
            R.id.details -> showDetails(recent)
            R.id.forget -> askToForget(recent)
            R.id.delete -> askToDelete(recent)
        }
    }

    private fun keepCopy(recent: Recent) {
        SceneCopy.start(activity, recent.uri, recent.name).onEnd { end ->
            if (end is SceneCopy.Failed) say(end.message)
            onChange()
        }
        onChange()
    }

    private fun askForName(recent: Recent) {
        val field = EditText(activity).apply {
            id = R.id.name
            inputType = InputType.TYPE_CLASS_TEXT or InputType.TYPE_TEXT_FLAG_CAP_SENTENCES
            setText(Texts.titleOf(recent.name))
            hint = activity.getString(R.string.rename)
            selectAll()
        }
        val frame = FrameLayout(activity).apply {
            val side = (20 * resources.displayMetrics.density).toInt()
            setPadding(side, 0, side, 0)
            addView(field)
        }
        AlertDialog.Builder(activity)
            .setTitle(R.string.rename)
            .setView(frame)
            .setPositiveButton(R.string.rename) { _, _ -> rename(recent, field.text.toString().trim()) }
            .setNegativeButton(R.string.cancel, null)
            .show()
    }

    private fun rename(recent: Recent, title: String) {
        if (title.isNotEmpty()) change { recents.rename(recent, title + Texts.endingOf(recent.name)) }
    }

    private fun share(recent: Recent) {
        Background.start {
            val intent = try {
                SharedFiles.send(activity, sharedUri(recent), "application/octet-stream")
            } catch (_: IOException) {
                null
            }
            activity.runOnUiThread { if (!activity.isDestroyed) startSharing(intent) }
        }
    }

    private fun startSharing(intent: Intent?) = try {
        if (intent == null) say(activity.getString(R.string.moved_or_deleted)) else activity.startActivity(intent)
    } catch (_: SecurityException) { // the permission to read it has ended
        say(activity.getString(R.string.scene_forbidden))
    }

    private fun sharedUri(recent: Recent): Uri = when {
        Scene.isSample(recent.uri) -> sampleToShare()
        library.owns(recent.uri) -> {
            val file = File(recent.uri.path!!)
            if (!file.exists()) throw IOException("$file")
            SharedFiles.uriOf(activity, file)
        }
        else -> recent.uri
    }

    private fun sampleToShare(): Uri {
        val file = SharedFiles.create(activity, "sample.glb")
        activity.assets.open("sample.glb").use { from -> file.outputStream().use { from.copyTo(it) } }
        return SharedFiles.uriOf(activity, file)
    }

    /** A line each. */
    fun factsOf(recent: Recent): String = listOfNotNull(
        listOfNotNull(
            recent.splats.takeIf { it > 0 }?.let { Texts.splats(activity, it) },
            recent.bytes.takeIf { it > 0 }?.let { Texts.size(activity, it) },
        ).joinToString(" · ").ifEmpty { null },
        recent.opened.takeIf { it > 0 }?.let {
            activity.getString(R.string.opened_at, DateFormat.getDateTimeInstance().format(Date(it)))
        },
        placeOf(recent.uri),
        recent.source?.let { activity.getString(R.string.copied_from, it.authority ?: it.toString()) },
    ).joinToString("\n")

    private fun showDetails(recent: Recent) {
        AlertDialog.Builder(activity)
            .setTitle(SceneCards.nameOf(activity, recent))
            .setMessage(factsOf(recent))
            .setPositiveButton(android.R.string.ok, null)
            .show()
    }

    private fun placeOf(uri: Uri): String = when {
        Scene.isSample(uri) -> activity.getString(R.string.sample_detail)
        library.owns(uri) -> activity.getString(R.string.kept_here, File(uri.path!!).name)
        else -> activity.getString(R.string.kept_elsewhere, uri.authority ?: uri.toString())
    }

    private fun askToForget(recent: Recent) = ask(
        activity.getString(R.string.forget_question, SceneCards.nameOf(activity, recent)), R.string.forget,
    ) {
        change { recents.forget(recent.uri) }
        UriPermissions.release(activity, recent.uri)
    }

    private fun askToDelete(recent: Recent) = ask(
        activity.getString(
            R.string.delete_question, SceneCards.nameOf(activity, recent),
            Texts.size(activity, recent.bytes),
        ),
        R.string.delete,
    ) {
        change {
            if (library.delete(recent.uri)) recents.forget(recent.uri)
        }
    }

    private fun ask(question: String, answer: Int, onYes: () -> Unit) {
        AlertDialog.Builder(activity)
            .setMessage(question)
            .setPositiveButton(answer) { _, _ -> onYes() }
            .setNegativeButton(R.string.cancel, null)
            .show()
    }

    private fun change(work: () -> Unit) {
        Background.start {
            work()
            activity.runOnUiThread(onChange)
        }
    }

    private fun say(text: String) = Toast.makeText(activity, text, Toast.LENGTH_LONG).show()
}
