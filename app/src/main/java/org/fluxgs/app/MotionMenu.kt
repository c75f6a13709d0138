package org.fluxgs.app

import android.app.Activity
import android.content.ActivityNotFoundException
import android.content.Intent
import android.net.Uri
import android.view.Menu
import android.view.MenuItem
import android.view.View
import android.widget.PopupMenu
import android.widget.Toast
import java.io.IOException

/** The menu of what moves the view, auto-orbit, saved views and paths, and of what is behind the scene. */
internal class MotionMenu(
    private val activity: Activity,
    private val session: () -> Session,
    private val scene: () -> Uri?,
    private val name: () -> String?,
    private val settings: () -> Settings,
    private val change: (Settings) -> Unit,
) {
    private var pathFile: ByteArray? = null // the last one that was played
    private var video: VideoDialog? = null

    fun show(anchor: View) {
        val popup = PopupMenu(activity, anchor)
        fill(popup.menu)
        popup.show()
    }

    private fun fill(menu: Menu) {
        fillWithMotion(menu)
        val start = settings().autoOrbit
        menu.entry(R.string.auto_orbit_at_start, start) { change(settings().copy(autoOrbit = it)) }
        val backdrops = menu.addSubMenu(0, R.string.backdrop, menu.size(), R.string.backdrop)
        activity.resources.getStringArray(R.array.backdrops).forEachIndexed { i, label ->
            val colour = Settings.BACKDROPS[i]
            val item = backdrops.add(0, i + 1, i, label)
            item.isChecked = settings().backdrop == colour
            item.does { change(settings().copy(backdrop = colour)) }
        }
        backdrops.setGroupCheckable(0, true, true)
    }

    private fun fillWithMotion(menu: Menu) {
        val motion = session().state()?.motion
        menu.entry(R.string.auto_orbit, motion == "drift") { session().drift(it) }
        menu.entry(R.string.walk, motion == "walk") { session().walk(it) }
        val views = scene()?.let { SavedViews(activity, it) } ?: return
        val all = views.all()
        menu.entry(R.string.save_view) { save(views) }
        if (all.isNotEmpty()) {
            val saved = menu.addSubMenu(0, R.string.saved_views, menu.size(), R.string.saved_views)
            all.forEachIndexed { i, place -> saved.view(i) { session().goTo(place) } }
            val delete = menu.addSubMenu(0, R.string.delete_view, menu.size(), R.string.delete_view)
            all.indices.forEach { i -> delete.view(i) { views.remove(i) } }
        }
        if (motion == "path") menu.entry(R.string.stop_path) { session().play(false) }
        else if (all.size > 1) menu.entry(R.string.play_views) { playThrough(all) }
        menu.entry(R.string.open_path) { choosePath() }
        menu.entry(R.string.save_video) { askForVideo(all) }
    }

    private fun Menu.entry(label: Int, checked: Boolean? = null, action: (on: Boolean) -> Unit) {
        val item = add(0, label, size(), label)
        item.isCheckable = checked != null
        item.isChecked = checked == true
        item.does { action(checked != true) }
    }

    private fun Menu.view(index: Int, action: () -> Unit) =
        add(0, index + 1, index, activity.getString(R.string.view_number, index + 1)).does(action)

    private fun MenuItem.does(action: () -> Unit) {
        setOnMenuItemClickListener {
            action()
            true
        }
    }

    // Saved views

    private fun save(views: SavedViews) {
        val place = session().place() ?: return
        say(if (views.add(place)) R.string.view_saved else R.string.views_full)
    }

    private fun playThrough(all: List<DoubleArray>) {
        session().pathThrough(all, closed = true, all.size * LEG_SECONDS)
        session().play(true)
    }

    // Videos

    private fun askForVideo(views: List<DoubleArray>) {
        val session = session()
        val choices = mutableListOf(choice(R.string.video_around) { session.pathAround(it) })
        if (views.size > 1) choices += choice(R.string.video_views) { session.pathThrough(views, true, it) }
        pathFile?.let { file -> choices += choice(R.string.video_file) { session.pathOf(file) } }
        video = VideoDialog(activity, session, name() ?: return).apply { ask(choices) }
    }

    private fun choice(label: Int, make: (Double) -> Double) = VideoDialog.Choice(activity.getString(label), make)

    fun leave() {
        video?.leave()
    }

    // Paths of files

    private fun choosePath() {
        val intent = Intent(Intent.ACTION_OPEN_DOCUMENT).addCategory(Intent.CATEGORY_OPENABLE).setType("*/*")
        try {
            @Suppress("DEPRECATION") // what is newer is in a library
            activity.startActivityForResult(intent, OPEN_PATH)
        } catch (_: ActivityNotFoundException) {
            say(R.string.no_picker)
        }
    }

    /** Plays the path of a file that was chosen. */
    fun openPath(file: Uri) {
        Background.start {
            val problem = try {
                val bytes = read(file)
                session().pathOf(bytes)
                pathFile = bytes
                null
            } catch (problem: IOException) {
                problem.message
            } catch (problem: RuntimeException) { // of what is in the file, and of its provider
                problem.message ?: problem.toString()
            }
            activity.runOnUiThread {
                if (problem == null) session().play(true)
                else say(activity.getString(R.string.path_unreadable, problem))
            }
        }
    }

    @Throws(IOException::class)
    private fun read(file: Uri): ByteArray {
        val stream = activity.contentResolver.openInputStream(file) ?: throw IOException(file.toString())
        stream.use {
            val bytes = ByteArray(LONGEST_FILE + 1)
            var count = 0
            while (count < bytes.size) {
                val more = it.read(bytes, count, bytes.size - count)
                if (more < 0) break
                count += more
            }
            return bytes.copyOf(count)
        }
    }

    private fun say(text: Int) = say(activity.getString(text))

    private fun say(text: String) = Toast.makeText(activity, text, Toast.LENGTH_LONG).show()

    companion object {
        const val OPEN_PATH = 7
        private const val LEG_SECONDS = 3.0
        private const val LONGEST_FILE = 1 shl 22
    }
}
