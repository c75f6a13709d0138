package org.fluxgs.app

import android.app.Activity
import android.content.ActivityNotFoundException
import android.content.Intent
import android.net.Uri
import android.widget.Toast

/** The system's file picker. */
internal object ScenePicker {
    private const val PICK = 1

    fun ask(activity: Activity) {
        // Scenes have no type of their own that file managers know: they are told by content
        val intent = Intent(Intent.ACTION_OPEN_DOCUMENT)
            .addCategory(Intent.CATEGORY_OPENABLE)
            .setType("*/*")
        try {
            @Suppress("DEPRECATION") // androidx's replacement is not worth its size here
            activity.startActivityForResult(intent, PICK)
        } catch (_: ActivityNotFoundException) {
            Toast.makeText(activity, R.string.no_picker, Toast.LENGTH_LONG).show()
        }
    }

    /** Of onActivityResult(): the scene that was picked, which can be read after a restart, too. */
    fun picked(activity: Activity, request: Int, result: Int, data: Intent?): Uri? {
        val uri = data?.data
        if (request != PICK || result != Activity.RESULT_OK || uri == null) return null
        UriPermissions.keep(activity, uri)
        return uri
    }
}
