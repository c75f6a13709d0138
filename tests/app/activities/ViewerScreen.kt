package org.fluxgs.app

import android.content.Intent
import android.graphics.Bitmap
import android.net.Uri
import android.os.Bundle
import android.os.SystemClock
import android.provider.Settings.Global
import android.view.MotionEvent
import org.junit.After
import org.junit.Before
import org.robolectric.Robolectric
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.android.controller.ActivityController
import org.robolectric.shadows.ShadowPopupMenu

/** The size of the scene's view in these tests. */
internal const val WIDTH = 640
internal const val HEIGHT = 480

/** A viewer that is opened, touched and looked at. */
abstract class ViewerScreen {
    protected val context = RuntimeEnvironment.getApplication()
    protected var controller: ActivityController<ViewerActivity>? = null
    protected val activity get() = controller!!.get()
    protected val session get() = activity.view(R.id.surface).let { (it as SceneSurface).session!! }

    @Before
    fun sharp() {
        pauseDisplay()
        Documents.install()
        Settings(scale = 1f, sorter = 2).save(context)
        animations(0f)
        Hints.tell(context)
    }

    @After
    fun close() {
        controller?.end()
        controller = null
    }

    /** The system's scale of animations; 0: nothing moves by itself. */
    protected fun animations(scale: Float) {
        Global.putFloat(context.contentResolver, Global.ANIMATOR_DURATION_SCALE, scale)
    }

    protected fun start(intent: Intent, state: Bundle? = null) {
        controller = Robolectric.buildActivity(ViewerActivity::class.java, intent)
        if (state == null) controller!!.create() else controller!!.create(state)
        controller!!.start().resume().visible()
        giveSurface(activity.view(R.id.surface) as SceneSurface, WIDTH, HEIGHT)
        pump()
    }

    protected fun open(uri: Uri?) =
        start(Intent(context, ViewerActivity::class.java).setData(uri))

    protected fun openAndDraw(uri: Uri? = null) {
        open(uri)
        until("the scene is drawn") { session.state()!!.drawn && !activity.isShown(R.id.loading) }
    }

    protected fun openAndFail(uri: Uri): String {
        open(uri)
        until("the app says that it cannot") { activity.isShown(R.id.loading_retry) }
        return activity.text(R.id.loading_detail)
    }

    /** Once no other frame is wanted. */
    protected fun settled(): Bitmap {
        val surface = activity.view(R.id.surface) as SceneSurface
        until("the image is still") { !surface.isAwake }
        return session.image()!!
    }

    protected var touched = 0L

    /** `at`: ms after the first finger came down. */
    protected fun touch(action: Int, at: Long, vararg points: Pair<Float, Float>) {
        if (action == MotionEvent.ACTION_DOWN) touched = SystemClock.uptimeMillis()
        val properties = Array(points.size) { index ->
            MotionEvent.PointerProperties().apply { id = index }
        }
        val places = Array(points.size) { index ->
            MotionEvent.PointerCoords().apply {
                x = points[index].first
                y = points[index].second
                pressure = 1f
            }
        }
        val event = MotionEvent.obtain(
            touched, touched + at, action, points.size, properties, places, 0, 0, 1f, 1f, 0, 0, 0,
            0,
        )
        activity.view(R.id.surface).dispatchTouchEvent(event)
        event.recycle()
        pump()
    }

    protected fun drag(from: Pair<Float, Float>, to: Pair<Float, Float>) {
        touch(MotionEvent.ACTION_DOWN, 0, from)
        for (i in 1..10) touch(
            MotionEvent.ACTION_MOVE, 30L * i,
            from.first + (to.first - from.first) * i / 10 to
                from.second + (to.second - from.second) * i / 10,
        )
        touch(MotionEvent.ACTION_MOVE, 900, to) // it rests: no fling
        touch(MotionEvent.ACTION_UP, 1000, to)
    }

    protected fun press(id: Int) {
        activity.view(id).performClick()
        pump()
    }

    /** An entry of the menu that More opens. */
    protected fun more(id: Int) {
        press(R.id.more)
        ShadowPopupMenu.getLatestPopupMenu().menu.performIdentifierAction(id, 0)
        pump()
    }

    /** What the machine says of a problem. */
    protected val cause get() = activity.text(R.id.loading_cause)

    /** The next activity that the one under test starts. */
    protected fun started(): Intent {
        var intent: Intent? = null
        until("something is started") {
            intent = shadowOf(activity).nextStartedActivity
            intent != null
        }
        return intent!!
    }
}
