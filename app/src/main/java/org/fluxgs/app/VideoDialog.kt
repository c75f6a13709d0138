package org.fluxgs.app

import android.app.Activity
import android.app.AlertDialog
import android.content.res.Configuration
import android.net.Uri
import android.os.Build
import android.view.View
import android.view.WindowManager
import android.widget.ArrayAdapter
import android.widget.ProgressBar
import android.widget.Spinner
import android.widget.Switch
import android.widget.Toast

/** Asks what a video is to show, makes it, and says how it goes. */
internal class VideoDialog(private val activity: Activity, private val session: Session, private val scene: String) {
    /** What a video may show: a path that it makes, and returns the seconds of. */
    class Choice(val name: String, val make: (seconds: Double) -> Double)

    private var export: VideoExport? = null

    fun ask(choices: List<Choice>) {
        val view = activity.layoutInflater.inflate(R.layout.video, null)
        val path = fill(view.findViewById(R.id.video_path), choices.map { it.name })
        val length = fill(view.findViewById(R.id.video_seconds), SECONDS.map { activity.getString(R.string.video_seconds, it) })
        AlertDialog.Builder(activity)
            .setTitle(R.string.save_video)
            .setView(view)
            .setNegativeButton(R.string.cancel, null)
            .setPositiveButton(R.string.video_start) { _, _ ->
                val fps = if (view.findViewById<Switch>(R.id.video_smooth).isChecked) 60 else 30
                val seconds = SECONDS[length.selectedItemPosition.coerceAtLeast(0)]
                make(choices[path.selectedItemPosition.coerceAtLeast(0)].make(seconds.toDouble()), fps)
            }
            .show()
    }

    private fun fill(spinner: Spinner, names: List<String>) = spinner.apply {
        adapter = ArrayAdapter(activity, android.R.layout.simple_spinner_item, names).apply {
            setDropDownViewResource(android.R.layout.simple_spinner_dropdown_item)
        }
    }

    private fun make(seconds: Double, fps: Int) {
        val size = try {
            VideoEncoder.sizeFor(activity.resources.configuration.orientation == Configuration.ORIENTATION_PORTRAIT)
        } catch (problem: Exception) { // of a device without an encoder
            return say(activity.getString(R.string.video_failed, problem.message))
        }
        val bar = ProgressBar(activity, null, android.R.attr.progressBarStyleHorizontal)
        bar.isIndeterminate = true
        val dialog = AlertDialog.Builder(activity)
            .setTitle(R.string.video_being_made)
            .setMessage(activity.getString(R.string.video_size, size.width, size.height, fps))
            .setView(bar)
            .setCancelable(false)
            .setNegativeButton(R.string.cancel) { _, _ -> export?.cancel() }
            .show()
        dialog.window?.addFlags(WindowManager.LayoutParams.FLAG_KEEP_SCREEN_ON)
        export = VideoExport(activity.applicationContext, session, scene, size, fps, seconds, { done, all, left ->
            bar.isIndeterminate = false
            bar.max = all
            bar.progress = done
            dialog.setMessage(progress(done, all, left))
        }, { video, problem ->
            export = null
            if (!activity.isDestroyed) dialog.dismiss()
            if (video != null) tell(video) else if (problem != null) say(activity.getString(R.string.video_failed, problem))
        }).apply { start() }
    }

    private fun progress(done: Int, all: Int, left: Long?): String {
        val frames = activity.getString(R.string.video_progress, done, all)
        if (left == null) return frames
        return frames + " · " + Texts.left(activity, left)
    }

    private fun tell(video: Uri) {
        if (Build.VERSION.SDK_INT >= 29) say(activity.getString(R.string.video_saved))
        else if (!activity.isDestroyed) activity.startActivity(SharedFiles.send(activity, video, VideoFile.TYPE))
    }

    private fun say(text: String) = Toast.makeText(activity, text, Toast.LENGTH_LONG).show()

    /** People have left the app, in which nothing is drawn any more. */
    fun leave() {
        export?.stop(activity.getString(R.string.stopped_by_leaving))
    }

    private companion object {
        val SECONDS = intArrayOf(10, 20, 30, 60)
    }
}
