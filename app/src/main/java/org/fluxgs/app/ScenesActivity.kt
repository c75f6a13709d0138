package org.fluxgs.app

import android.app.Activity
import android.app.ActivityManager
import android.app.AlertDialog
import android.content.Intent
import android.content.pm.ConfigurationInfo
import android.net.Uri
import android.os.Build
import android.os.Bundle
import android.os.Handler
import android.os.Looper
import android.view.Menu
import android.view.View
import android.widget.GridView
import android.widget.PopupMenu
import android.widget.TextView
import kotlin.concurrent.thread

/** The start: the sample, the scenes of the library and those that were opened last, and a way to open others. */
class ScenesActivity : Activity() {
    private lateinit var recents: Recents
    private lateinit var library: Library
    private lateinit var cards: SceneCards
    private lateinit var grid: GridView
    private var pane: ScenePane? = null // where there is room
    private var selected: Uri? = null
    private var shown = false // the list
    private val main = Handler(Looper.getMainLooper())
    private val look = Runnable { load() } // while something is copied

    override fun onCreate(state: Bundle?) {
        super.onCreate(state)
        setContentView(R.layout.scenes)
        Insets.pad(findViewById(R.id.root))
        recents = Recents(this)
        library = Library(this)
        val menu = SceneMenu(this, ::load)
        cards = SceneCards(this, menu::show)
        pane = findViewById<View>(R.id.pane)?.let { view -> ScenePane(this, view, menu) { open(it.uri) } }
        selected = state?.getString(SELECTED)?.let { Uri.parse(it) }
        grid = findViewById<GridView>(R.id.grid).apply {
            adapter = cards
            setOnItemClickListener { _, _, position, _ -> tapped(position) }
            setOnItemLongClickListener { _, card, position, _ ->
                menu.show(cards.recentAt(position), card.findViewById(R.id.menu))
                true
            }
        }
        findViewById<View>(R.id.open).setOnClickListener { ScenePicker.ask(this) }
        findViewById<View>(R.id.more).setOnClickListener { showMore(it) }
        if (state == null) Background.start {
            SceneCopy.removeOldParts(library)
            UriPermissions.releaseAllBut(applicationContext, recents.all().map { it.uri }.toSet())
        }
        if (hasOpenGl()) checkDriver() else tellProblem(getString(R.string.no_opengl))
    }

    /** Where there is a pane, the first tap shows the scene there. */
    private fun tapped(position: Int) {
        val uri = cards.recentAt(position).uri
        if (pane == null || uri == selected) return open(uri)
        select(position)
    }

    private fun select(position: Int) {
        selected = cards.recentAt(position).uri
        grid.setItemChecked(position, true)
        pane?.show(cards.entryAt(position))
    }

    /** Or the first after the sample. */
    private fun selectAgain() {
        val known = selected?.let { cards.positionOf(it) } ?: -1
        select(if (known >= 0) known else (cards.count - 1).coerceAtMost(1))
        if (!shown) grid.setSelection(grid.checkedItemPosition) // perhaps far down
        shown = true
    }

    override fun onSaveInstanceState(state: Bundle) {
        super.onSaveInstanceState(state)
        state.putString(SELECTED, selected?.toString())
    }

    private fun showMore(button: View) {
        val popup = PopupMenu(this, button)
        popup.inflate(R.menu.scenes)
        offerOtherWays(popup.menu)
        popup.menu.findItem(ORDERS.getValue(order())).isChecked = true
        popup.setOnMenuItemClickListener {
            when (it.itemId) {
                R.id.benchmark -> benchmark()
                R.id.about -> showAbout()
                Menu.NONE -> startActivity(it.intent!!)
                else -> ORDERS.entries.find { (_, id) -> id == it.itemId }?.let { (order) -> sortBy(order) }
            }
            true
        }
        popup.show()
    }

    /** To scenes, that this build of the app has. */
    private fun offerOtherWays(menu: Menu) {
        for (way in packageManager.queryIntentActivities(Intent(ADD_SCENES).setPackage(packageName), 0)) {
            val intent = Intent(ADD_SCENES).setClassName(packageName, way.activityInfo.name)
            menu.add(way.loadLabel(packageManager)).intent = intent
        }
    }

    private val preferences get() = getSharedPreferences("scenes", MODE_PRIVATE)

    private fun order() = preferences.getInt("order", 0).let { SceneOrder.entries.getOrNull(it) } ?: SceneOrder.OPENED

    private fun sortBy(order: SceneOrder) {
        preferences.edit().putInt("order", order.ordinal).apply()
        load()
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

    override fun onPause() {
        main.removeCallbacks(look)
        super.onPause()
    }

    private fun load() {
        val order = order()
        Background.start {
            val entries = recents.all().map { SceneEntry(it, recents.image(it)) }
            val known = entries.map { it.recent.uri }
            val unknown = library.files().map { Uri.fromFile(it) to it }.filter { (uri) -> uri !in known }
                .mapIndexed { i, (uri, file) -> SceneEntry(Recent(uri, file.name, file.length(), 0, null, -1L - i), null) }
            runOnUiThread { show(entries + unknown, order) }
        }
    }

    private fun show(entries: List<SceneEntry>, order: SceneOrder) {
        if (isDestroyed) return
        cards.show(entries, order)
        if (pane != null) selectAgain()
        main.removeCallbacks(look)
        if (SceneCopy.isAny) main.postDelayed(look, LOOK_EVERY_MS)
    }

    private fun versionText(): String {
        val version = getString(R.string.version, BuildFacts.version(this))
        return if (BuildFacts.isCheckBuild) "$version\n" + getString(R.string.check_build)
        else version
    }

    private fun open(uri: Uri) {
        startActivity(Intent(this, ViewerActivity::class.java).setData(uri))
    }

    @Deprecated("androidx's replacement is not worth its size here")
    override fun onActivityResult(request: Int, result: Int, data: Intent?) {
        ScenePicker.picked(this, request, result, data)?.let { open(it) }
    }

    private fun benchmark() {
        startActivity(Intent(this, BenchmarkActivity::class.java).setData(Scene.SAMPLE))
    }

    private companion object {
        const val ADD_SCENES = "org.fluxgs.app.ADD_SCENES"
        const val SELECTED = "selected"
        const val LOOK_EVERY_MS = 500L
        val ORDERS = mapOf(
            SceneOrder.OPENED to R.id.by_opened, SceneOrder.NAME to R.id.by_name, SceneOrder.SIZE to R.id.by_size,
        )
    }
}
