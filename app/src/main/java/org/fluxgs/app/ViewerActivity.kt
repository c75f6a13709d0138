package org.fluxgs.app

import android.app.Activity
import android.content.ComponentCallbacks2
import android.content.Intent
import android.net.Uri
import android.os.BadParcelableException
import android.os.Build
import android.os.Bundle
import android.os.Handler
import android.os.Looper
import android.os.Parcelable
import android.os.SystemClock
import android.view.KeyEvent
import android.view.View
import android.widget.ImageButton
import android.widget.PopupMenu
import android.widget.TextView
import android.widget.Toast
import java.io.IOException
import kotlin.math.abs
import kotlin.math.min

/** A scene in full screen: opened from the list, by "open with", or shared to the app. */
class ViewerActivity : Activity() {
    /** A scene by the name that people know it by. */
    private data class Opened(val uri: Uri, val name: String, val bytes: Long, val number: Long)

    private lateinit var uri: Uri // of the scene that is wanted
    private lateinit var session: Session
    private lateinit var gyroscope: Gyroscope
    private lateinit var recents: Recents
    private lateinit var thermals: Thermals
    private lateinit var surface: SceneSurface
    private lateinit var settings: Settings
    private lateinit var loadingView: LoadingView
    private lateinit var tools: ToolsFade
    private lateinit var undo: Notice
    private lateinit var copyOffer: CopyOffer
    private lateinit var hints: Hints
    private var opening: SceneOpening? = null
    private var name = "" // of the scene that is being loaded
    private var heat = Heat()
    private val opened = mutableMapOf<Long, Opened>() // by the numbers of their loadings
    private var shown: Opened? = null // the scene on the screen
    private var busy = false // until the scene that is wanted is shown, or no longer wanted
    private lateinit var budget: GraphicsBudget
    private var appliedFrameSeconds = 0f
    private var measuring = false // the benchmark has the device for itself
    private var looksAround = false // by the gyroscope
    private var touchedAt = 0L
    private var lastTurn = DoubleArray(4) // of the view, since which the screen stays on
    private var lastRead = 0L
    private var droppedPlace: DoubleArray? = null // of a scene that made room for another viewer's
    private val main = Handler(Looper.getMainLooper())

    private var startsStill = false // the view is one that people left, not one to begin at
    private val motion = MotionMenu(this, { session }, { shown?.uri }, { shown?.name }, { settings }, ::change)

    private val look = object : Runnable {
        override fun run() {
            update()
            main.postDelayed(this, LOOK_EVERY_MS)
        }
    }

    override fun onCreate(state: Bundle?) {
        super.onCreate(state)
        setContentView(R.layout.viewer)
        Insets.immersive(window)
        for (id in intArrayOf(R.id.controls, R.id.notes, R.id.hints)) Insets.pad(findViewById(id))
        recents = Recents(this)
        thermals = Thermals(this)
        settings = Settings.load(this)
        session = Session()
        gyroscope = Gyroscope(this) { rotation, turns, time -> session.turn(rotation, turns, time) }
        budget = GraphicsBudget(this)
        surface = findViewById(R.id.surface)
        surface.session = session
        loadingView = LoadingView(
            findViewById(R.id.loading),
            LoadingView.Actions(::cancelLoading, ::retry, ::leave) { ScenePicker.ask(this) },
        )
        setUpControls()
        setUpNotices()
        apply(settings)
        val wanted = state?.getString(SCENE)?.let { Uri.parse(it) } ?: uriOf(intent)
        uri = wanted ?: Scene.SAMPLE
        if (state == null) UriPermissions.keep(this, uri)
        if (wanted == null && intent.action == Intent.ACTION_SEND)
            loadingView.failed(nothingShared())
        else begin(state?.getDoubleArray(PLACE))
        if (state?.getBoolean(BARE) == true) tools.hide()
        if (state?.getBoolean(GYROSCOPE) == true) lookAround(true)
    }

    /** Another scene is opened while one is looked at. */
    override fun onNewIntent(intent: Intent) {
        super.onNewIntent(intent)
        val other = uriOf(intent) ?: return loadingView.failed(nothingShared())
        setIntent(intent)
        UriPermissions.keep(this, other)
        openOther(other)
    }

    private fun openOther(other: Uri) {
        remember()
        uri = other
        begin(null)
    }

    private fun nothingShared() = Problem(getString(R.string.nothing_shared), again = false)

    @Deprecated("androidx's replacement is not worth its size here")
    override fun onActivityResult(request: Int, result: Int, data: Intent?) {
        if (request == MotionMenu.OPEN_PATH && result == RESULT_OK) data?.data?.let { motion.openPath(it) }
        ScenePicker.picked(this, request, result, data)?.let { openOther(it) }
    }

    private fun uriOf(intent: Intent): Uri? {
        if (intent.action != Intent.ACTION_SEND) return intent.data
        @Suppress("DEPRECATION") // the typed one is of newer Android only
        return try {
            intent.getParcelableExtra<Parcelable>(Intent.EXTRA_STREAM) as? Uri
        } catch (_: BadParcelableException) {
            null
        }
    }

    // Opening

    private fun begin(place: DoubleArray?) {
        opening?.cancel()
        session.cancelLoading()
        name = ""
        busy = true
        startsStill = place != null
        budget.begin()
        apply(settings)
        loadingView.opening()
        undo.hide()
        val wanted = uri
        val last = Background.start { lookUp(wanted) }
        opening = SceneOpening(this, uri, { descriptor, facts ->
            val known = last.get()
            name = known?.takeIf { it.named }?.name ?: facts.name
            val bytes = maxOf(descriptor.statSize, facts.bytes, 0)
            val number = session.load(
                descriptor.detachFd(), name, facts.bytes, FreeMemory.forScene(this),
                place ?: known?.place,
            )
            loadingView.loads()
            opened[number] = Opened(wanted, name, bytes, number)
        }, loadingView::failed, { loadingView.slow() }, last)
        opening?.start()
    }

    /** In the background: what is known of a scene. While nothing else is shown, how it looked, too. */
    private fun lookUp(wanted: Uri): Recent? {
        val known = recents.find(wanted) ?: return null
        val image = recents.image(known) ?: return known
        runOnUiThread { if (uri == wanted && shown == null) loadingView.preview(image) }
        return known
    }

    private fun cancelLoading() {
        opening?.cancel()
        session.cancelLoading()
        val before = shown ?: return finish()
        uri = before.uri
        busy = false
        loadingView.hide()
    }

    /** After something that cannot be shown. */
    private fun leave() {
        if (session.state()?.error.isNullOrEmpty()) cancelLoading() else finish()
    }

    private fun retry() {
        val place = if (shown?.uri == uri) session.place() else null
        dropScene() // which has the memory that the other may have wanted
        asleep.forEach { it.dropUnseen() }
        begin(place)
    }

    /** For what is in front, this app or another one: the scene is opened again when it is seen. */
    private fun dropUnseen() {
        if (shown?.uri != uri) return // nothing, or it is being opened
        droppedPlace = session.place()
        dropScene()
    }

    /** Gives back what the scene takes, on the GPU, too. */
    private fun dropScene() {
        surface.session = null // has let go of the window when the next one takes it
        session.close()
        session = Session()
        heat = Heat() // what it knows of
        opened.clear() // the next one counts anew
        shown = null
        surface.session = session
        apply(settings)
    }

    // What is shown

    private fun update() {
        val state = session.state() ?: return
        if (frameSeconds() != appliedFrameSeconds) apply(settings)
        tellHeat()
        surface.goal = if (state.stats.fps > 0) state.stats.goal.toFloat() else 0f
        fitMemory { budget.look(state.stats.memory, state.stats.reduced) }
        loadingView.show(state, if (busy) name else shown?.name ?: name) { FreeMemory.forScene(this) }
        if (state.drawn && state.shown != shown?.number) opened[state.shown]?.let { appeared(it, state) }
        val hud = findViewById<TextView>(R.id.hud)
        if (state.drawn) Hud.show(hud, state.stats, settings.hud) else hud.visibility = View.GONE
        findViewById<View>(R.id.stick).visibility = if (state.motion == "walk") View.VISIBLE else View.GONE
        findViewById<View>(R.id.tools).visibility = if (state.drawn) View.VISIBLE else View.INVISIBLE
        tools.look(state.stats.fps > 0)
        copyOffer.look()
        stayAwake(state)
    }

    private fun tellHeat() {
        val now = thermals.now()
        if (now == heat) return
        heat = now
        session.setHeat(now.status, now.headroom)
    }

    /**
     * The screen stays on for who looks at something, and not all night for who has gone to bed: for a
     * while after a touch, a turn of the device that is no trembling, or another part of a file.
     */
    private fun stayAwake(state: SessionState) {
        val drifts = state.motion == "drift" // which nobody may be looking at
        val turn = if (drifts) null else session.place()?.copyOfRange(3, 7) // w, x, y, z
        val turned = turn != null && abs((0..3).sumOf { turn[it] * lastTurn[it] }) < STILL
        if (turned || state.loading.read != lastRead) {
            touchedAt = SystemClock.elapsedRealtime()
            lastTurn = turn ?: lastTurn
            lastRead = state.loading.read
        }
        surface.keepScreenOn = SystemClock.elapsedRealtime() - touchedAt < AWAKE_MS
    }

    override fun onUserInteraction() {
        super.onUserInteraction()
        touchedAt = SystemClock.elapsedRealtime()
    }

    /** Perhaps not the one that is wanted: another may have been asked for, or Cancel come too late. */
    private fun appeared(scene: Opened, state: SessionState) {
        shown = if (scene.bytes > 0) scene else scene.copy(bytes = state.loading.read)
        opened.keys.removeAll { it < scene.number }
        if (scene.uri == uri) busy = false
        if (!busy) uri = scene.uri
        title(scene.name)
        remember()
        tellOfDropped(state)
        if (settings.autoOrbit && !startsStill && !looksAround && Motion.isWelcome(this)) session.drift(true)
        startsStill = false
        shown?.let { copyOffer.show(it.uri, it.name, it.bytes) { work -> runOnUiThread(work) } }
        hints.showOnce()
    }

    private fun title(name: String) {
        findViewById<TextView>(R.id.title).text = Texts.titleOf(name)
    }

    /** The app's own copy of a scene takes its place. */
    private fun kept(source: Uri, copy: Uri) {
        if (uri == source) uri = copy
        if (shown?.uri == source) shown = shown?.copy(uri = copy)
    }

    private fun tellOfDropped(state: SessionState) {
        if (state.dropped == 0L) return
        val dropped = state.dropped.coerceAtMost(Int.MAX_VALUE.toLong()).toInt()
        say(resources.getQuantityString(R.plurals.dropped, dropped, Texts.count(state.dropped)))
    }

    private fun remember() {
        val scene = shown ?: return
        val session = session
        val place = session.place()
        val state = session.state() ?: return
        if (!state.drawn || state.shown != scene.number) return
        Background.start {
            val image = session.image(Recents.PICTURE, scene.number)
            recents.remember(scene.uri, scene.name, scene.bytes, state.stats.splats, place, image)
        }
    }

    // Controls

    private fun setUpControls() {
        tools = ToolsFade(findViewById(R.id.controls))
        surface.onTap = { tools.toggle() }
        button(R.id.back) { finish() }
        button(R.id.reset) { resetView() }
        button(R.id.screenshot) { takeScreenshot() }
        findViewById<ThumbStick>(R.id.stick).onMove = { right, ahead -> session.stick(right, ahead) }
        button(R.id.motion) { motion.show(findViewById(R.id.motion)) }
        button(R.id.gyroscope) { lookAround(!looksAround) }
        button(R.id.more) { showMore() }
        if (!gyroscope.isThere) findViewById<View>(R.id.gyroscope).visibility = View.GONE
    }

    private fun button(id: Int, action: () -> Unit) {
        val button = findViewById<ImageButton>(id)
        button.setOnClickListener { action() }
        button.tooltipText = button.contentDescription
    }

    private fun setUpNotices() {
        undo = Notice(findViewById(R.id.undo))
        copyOffer = CopyOffer(this, Notice(findViewById(R.id.copy)), ::kept, ::say)
        hints = Hints(findViewById(R.id.hints))
    }

    private fun showMore() {
        val popup = PopupMenu(this, findViewById(R.id.more))
        popup.inflate(R.menu.viewer)
        popup.menu.findItem(R.id.statistics).isChecked = settings.hud
        popup.setOnMenuItemClickListener {
            choose(it.itemId)
            true
        }
        popup.show()
    }

    private fun choose(id: Int) {
        when (id) {
            R.id.flip -> flip()
            R.id.quality -> QualitySheet(this, settings, ::change).show()
            R.id.statistics -> change(settings.copy(hud = !settings.hud))
            R.id.measure -> measure()
        }
    }

    private fun resetView() {
        val before = session.place()
        session.resetView()
        if (before == null || shown == null) return
        val back = Notice.Answer(R.string.undo) { session.goTo(before) }
        undo.show(getString(R.string.view_reset), back, forMs = UNDO_MS)
    }

    private fun flip() {
        undo.hide() // which would turn it back
        session.flipUp()
    }

    private fun change(changed: Settings) {
        changed.save(this)
        apply(changed)
    }

    private fun lookAround(on: Boolean) {
        looksAround = on
        gyroscope.on = on
        val button = findViewById<View>(R.id.gyroscope)
        button.isActivated = on
        button.isSelected = on // which is read out
        apply(settings)
    }

    private fun apply(changed: Settings) {
        settings = changed
        appliedFrameSeconds = frameSeconds()
        session.set(changed, looksAround, appliedFrameSeconds, budget.bytes)
    }

    /** The shortest that the display can have: what it has now may be what was asked for. */
    private fun frameSeconds(): Float {
        @Suppress("DEPRECATION") // Activity.display is of newer Android only
        val display = windowManager.defaultDisplay
        val now = display.mode
        val rate = display.supportedModes
            .filter { it.physicalWidth == now.physicalWidth && it.physicalHeight == now.physicalHeight }
            .maxOfOrNull { it.refreshRate } ?: now.refreshRate
        val most = if (settings.mostFrames > 0) settings.mostFrames.toFloat() else Float.MAX_VALUE
        return 1 / min(if (rate > 1) rate else 60f, most)
    }

    private fun takeScreenshot() {
        val session = session
        val scene = shown?.name ?: return say(getString(R.string.screenshot_of_nothing))
        Background.start {
            try {
                val saved = session.image()?.let { Gallery.save(applicationContext, it, scene) }
                runOnUiThread {
                    if (saved != null) tellOfSaved(saved)
                    else say(getString(R.string.screenshot_of_nothing))
                }
            } catch (problem: IOException) {
                runOnUiThread { say(getString(R.string.screenshot_failed, problem.message)) }
            }
        }
    }

    private fun say(text: String) {
        Toast.makeText(this, text, Toast.LENGTH_LONG).show()
    }

    private fun tellOfSaved(image: Uri) {
        if (Build.VERSION.SDK_INT >= 29)
            say(getString(R.string.screenshot_saved))
        else if (!isDestroyed) startActivity(SharedFiles.send(this, image, "image/png"))
    }

    private fun measure() {
        if (shown?.uri != uri) return say(getString(R.string.nothing_to_measure))
        remember()
        Background.start { runOnUiThread { startMeasuring() } } // once its image has been kept
    }

    /** The scene's memory is free before the benchmark asks how much there is. */
    private fun startMeasuring() {
        if (isFinishing || shown?.uri != uri) return
        val intent = Intent(this, BenchmarkActivity::class.java)
            .setData(uri)
            .addFlags(Intent.FLAG_GRANT_READ_URI_PERMISSION)
        try {
            startActivity(intent)
            measuring = true
            opening?.cancel()
            dropScene()
        } catch (_: SecurityException) { // the permission has ended since the scene was opened
            say(getString(R.string.scene_forbidden))
        }
    }

    override fun onKeyDown(code: Int, event: KeyEvent) = surface.key(event) || super.onKeyDown(code, event)

    override fun onKeyUp(code: Int, event: KeyEvent) = surface.key(event) || super.onKeyUp(code, event)

    // Life

    /** Seen, though perhaps beside another app that has the focus: a split screen before Android 10. */
    override fun onStart() {
        super.onStart()
        asleep.remove(this)
        surface.running = true
        droppedPlace?.let { begin(it) }
        droppedPlace = null
        touchedAt = SystemClock.elapsedRealtime()
        look.run()
    }

    override fun onStop() {
        main.removeCallbacks(look)
        motion.leave()
        surface.running = false
        asleep.add(this)
        Background.start { runOnUiThread { letGo() } } // once there is an image for the list
        super.onStop()
    }

    /** Nobody sees the scene: what it is drawn with is made again afterwards. */
    private fun letGo() {
        if (this in asleep) session.freeGraphics()
    }

    override fun onResume() {
        super.onResume()
        if (measuring) begin(null)
        measuring = false
        Insets.immersive(window)
        gyroscope.on = looksAround
        if (!Motion.isWelcome(this)) session.drift(false)
    }

    override fun onPause() {
        remember() // while there is an image
        gyroscope.on = false
        super.onPause()
    }

    override fun onSaveInstanceState(state: Bundle) {
        super.onSaveInstanceState(state)
        if (opening != null) state.putString(SCENE, uri.toString())
        if (shown?.uri == uri) session.place()?.let { state.putDoubleArray(PLACE, it) }
        state.putBoolean(BARE, tools.hidden)
        state.putBoolean(GYROSCOPE, looksAround)
    }

    override fun onTrimMemory(level: Int) {
        super.onTrimMemory(level)
        if (level >= ComponentCallbacks2.TRIM_MEMORY_BACKGROUND && this in asleep) dropUnseen()
        @Suppress("DEPRECATION")
        if (level == ComponentCallbacks2.TRIM_MEMORY_RUNNING_CRITICAL)
            fitMemory { budget.shrink(session.state()?.stats?.memory ?: 0) }
    }

    private fun fitMemory(change: () -> Boolean) {
        val before = budget.bytes
        if (!change()) return
        if (budget.bytes < before) say(getString(R.string.memory_short))
        apply(settings)
    }

    override fun onDestroy() {
        asleep.remove(this)
        opening?.cancel()
        surface.session = null
        session.close()
        super.onDestroy()
    }

    internal companion object {
        const val LOOK_EVERY_MS = 200L
        private const val SCENE = "scene"
        private const val PLACE = "place"
        private const val BARE = "bare"
        private const val GYROSCOPE = "gyroscope"
        const val AWAKE_MS = 5 * 60_000L
        const val UNDO_MS = 8_000L
        private const val STILL = 0.999 // cosine of half of 5°
        private val asleep = mutableSetOf<ViewerActivity>() // that nobody sees, until they are destroyed
    }
}
