package org.fluxgs.app

import android.app.Activity
import android.app.ActivityManager
import android.app.AlertDialog
import android.content.ActivityNotFoundException
import android.content.Intent
import android.content.pm.ConfigurationInfo
import android.graphics.Bitmap
import android.net.Uri
import android.os.Build
import android.os.Bundle
import android.view.LayoutInflater
import android.view.View
import android.view.ViewGroup
import android.widget.BaseAdapter
import android.widget.GridView
import android.widget.ImageView
import android.widget.TextView
import android.widget.Toast
import kotlin.concurrent.thread

/** The start: the sample, the scenes that were opened last, and a way to open others. */
class ScenesActivity : Activity() {
    private lateinit var recents: Recents
    private lateinit var grid: GridView
    private var sample: Entry? = null // once it was looked at
    private var shown = emptyList<Entry>()

    private class Entry(val recent: Recent, val image: Bitmap?)

    override fun onCreate(state: Bundle?) {
        super.onCreate(state)
        setContentView(R.layout.scenes)
        Insets.pad(findViewById(R.id.root))
        getExternalFilesDir(null) // makes it, for who sends scenes there by adb
        recents = Recents(this)
        grid = findViewById(R.id.grid)
        grid.emptyView = null
        grid.adapter = Adapter()
        grid.setOnItemClickListener { _, _, position, _ -> open(uriAt(position)) }
        grid.setOnItemLongClickListener { _, _, position, _ -> askToForget(position) }
        findViewById<View>(R.id.open).setOnClickListener { pick() }
        findViewById<View>(R.id.benchmark).setOnClickListener { benchmark() }
        findViewById<TextView>(R.id.version).apply {
            text = versionText()
            setOnClickListener { showAbout() }
        }
        if (state == null) Background.start {
            UriPermissions.releaseAllBut(applicationContext, recents.all().map { it.uri }.toSet())
        }
        if (hasOpenGl()) checkDriver() else tellProblem(getString(R.string.no_opengl))
    }

    /** Now, rather than when the first scene waits for it. */
    private fun checkDriver() = thread(name = "driver-check", isDaemon = true) {
        val check = DriverCheck.of(applicationContext)
        if (check?.right == false) runOnUiThread { tellProblem(DriverCheck.textOf(this)) }
    }

    private fun tellProblem(text: String) {
        findViewById<TextView>(R.id.problem).apply {
            this.text = text
            visibility = View.VISIBLE
        }
    }

    private fun showAbout() {
        val driver = DriverCheck.now?.let { "${it.renderer}\n${it.version}" } ?: ""
        AlertDialog.Builder(this)
            .setTitle(R.string.app_name)
            .setMessage(
                listOf(
                    versionText(), "${Build.MANUFACTURER} ${Build.MODEL}, Android ${Build.VERSION.RELEASE}",
                    driver, DriverCheck.textOf(this),
                ).filter { it.isNotBlank() }.joinToString("\n\n"),
            )
            .setPositiveButton(android.R.string.ok, null)
            .show()
    }

    /** OpenGL ES 3.1, or nobody knows. */
    private fun hasOpenGl(): Boolean {
        val version = getSystemService(ActivityManager::class.java).deviceConfigurationInfo
            ?.reqGlEsVersion ?: ConfigurationInfo.GL_ES_VERSION_UNDEFINED
        return version == ConfigurationInfo.GL_ES_VERSION_UNDEFINED || version >= 0x30001
    }

    override fun onResume() {
        super.onResume()
        load()
    }

    private fun load() {
        Background.start {
            val entries = recents.all().map { Entry(it, recents.image(it)) }
            val known = entries.map { it.recent.uri }
            val sent = sentFiles().filter { it.uri !in known }.map { Entry(it, null) }
            runOnUiThread { show(entries + sent) }
        }
    }

    /** Scenes in the app's own folder, to which adb sends them, and that no file picker shows. */
    private fun sentFiles(): List<Recent> =
        (getExternalFilesDir(null)?.listFiles() ?: emptyArray())
            .filter { it.isFile && it.extension.lowercase() in SCENE_ENDINGS }
            .sortedBy { it.name }
            .mapIndexed { i, file -> Recent(Uri.fromFile(file), file.name, file.length(), 0, null, -1L - i) }

    private fun show(entries: List<Entry>) {
        val (samples, others) = entries.partition { Scene.isSample(it.recent.uri) }
        sample = samples.firstOrNull()
        shown = others
        (grid.adapter as BaseAdapter).notifyDataSetChanged()
    }

    private fun versionText(): String {
        val version = getString(R.string.version, BuildFacts.version(this))
        return if (BuildFacts.isCheckBuild) "$version\n" + getString(R.string.check_build)
        else version
    }

    private fun entryAt(position: Int) = if (position == 0) sample else shown[position - 1]

    private fun uriAt(position: Int) = if (position == 0) Scene.SAMPLE else shown[position - 1].recent.uri

    private fun open(uri: Uri) {
        startActivity(Intent(this, ViewerActivity::class.java).setData(uri))
    }

    private fun askToForget(position: Int): Boolean {
        if (position == 0) return false
        val recent = shown[position - 1].recent
        if (recent.id < 0) return false // a file that was sent is no entry that could be taken off
        AlertDialog.Builder(this)
            .setMessage(getString(R.string.forget_question, recent.name))
            .setPositiveButton(R.string.forget) { _, _ -> forget(recent) }
            .setNegativeButton(android.R.string.cancel, null)
            .show()
        return true
    }

    private fun forget(recent: Recent) {
        Background.start { recents.forget(recent.uri) }
        UriPermissions.release(this, recent.uri)
        load()
    }

    private fun pick() {
        // Scenes have no type of their own that file managers know: they are told by content
        val intent = Intent(Intent.ACTION_OPEN_DOCUMENT)
            .addCategory(Intent.CATEGORY_OPENABLE)
            .setType("*/*")
        try {
            @Suppress("DEPRECATION")
            startActivityForResult(intent, PICK)
        } catch (_: ActivityNotFoundException) {
            Toast.makeText(this, R.string.no_picker, Toast.LENGTH_LONG).show()
        }
    }

    @Deprecated("androidx's replacement is not worth its size here")
    override fun onActivityResult(request: Int, result: Int, data: Intent?) {
        val uri = data?.data
        if (request != PICK || result != RESULT_OK || uri == null) return
        UriPermissions.keep(this, uri)
        open(uri)
    }

    private fun benchmark() {
        startActivity(Intent(this, BenchmarkActivity::class.java).setData(Scene.SAMPLE))
    }

    private inner class Adapter : BaseAdapter() {
        override fun getCount() = shown.size + 1

        override fun getItem(position: Int): Any = uriAt(position)

        override fun getItemId(position: Int) = if (position == 0) 0L else shown[position - 1].recent.id

        override fun hasStableIds() = true

        override fun getView(position: Int, old: View?, parent: ViewGroup): View {
            val view = old
                ?: LayoutInflater.from(this@ScenesActivity).inflate(R.layout.scene, parent, false)
            val entry = entryAt(position)
            val recent = entry?.recent
            val name = if (position == 0) getString(R.string.sample_scene) else recent!!.name
            val detail = recent?.let { detailOf(it) } ?: getString(R.string.sample_detail)
            view.findViewById<TextView>(R.id.name).text = name
            view.findViewById<TextView>(R.id.detail).text = detail
            val image = view.findViewById<ImageView>(R.id.image)
            image.setImageBitmap(entry?.image)
            view.contentDescription = "$name, $detail"
            return view
        }
    }

    private fun detailOf(recent: Recent) =
        if (recent.splats == 0L) Texts.megabytes(recent.bytes)
        else getString(
            R.string.scene_detail, Texts.count(recent.splats), Texts.megabytes(recent.bytes),
        )

    private companion object {
        const val PICK = 1
        val SCENE_ENDINGS = setOf("glb", "ply", "spz", "splat", "sog")
    }
}
