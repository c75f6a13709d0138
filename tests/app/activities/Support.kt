package org.fluxgs.app

import android.app.Activity
import android.app.ActivityManager
import android.content.ContentProvider
import android.content.ContentValues
import android.database.Cursor
import android.database.MatrixCursor
import android.graphics.Bitmap
import android.graphics.BitmapFactory
import android.graphics.Canvas
import android.graphics.SurfaceTexture
import android.net.Uri
import android.os.Looper
import android.os.ParcelFileDescriptor
import android.provider.OpenableColumns
import android.view.Surface
import android.view.SurfaceHolder
import android.view.View
import java.io.File
import java.io.FileNotFoundException
import java.io.RandomAccessFile
import java.lang.reflect.Proxy
import java.time.Duration
import kotlin.math.log10
import kotlin.math.max
import org.junit.Assert.fail
import org.robolectric.Robolectric
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.android.controller.ActivityController
import org.robolectric.annotation.Implementation
import org.robolectric.annotation.Implements
import org.robolectric.annotation.RealObject
import org.robolectric.shadows.ShadowChoreographer
import org.robolectric.shadows.ShadowParcelFileDescriptor

/** Scenes and images that tests/app/activities/run has made on the desktop. */
internal val material = File(System.getProperty("fluxgs.material")!!)

/** Where images of the screens are left. */
internal val screens = File(System.getProperty("fluxgs.screens")!!)

/** What the system says of the memory that is free. */
internal fun memory(bytes: Long, low: Boolean = false) {
    val info = ActivityManager.MemoryInfo().apply {
        availMem = bytes
        totalMem = 4L shl 30
        threshold = 0
        lowMemory = low
    }
    val context = RuntimeEnvironment.getApplication()
    shadowOf(context.getSystemService(ActivityManager::class.java)).setMemoryInfo(info)
}

/** Lets the main thread do what it has to for some milliseconds of its clock, and others work. */
internal fun pump(milliseconds: Long = 20) {
    shadowOf(Looper.getMainLooper()).idleFor(Duration.ofMillis(milliseconds))
    Thread.sleep(4)
}

/** Frames of the display come with the clock of [pump], not by themselves. */
internal fun pauseDisplay() {
    ShadowChoreographer.setPaused(true)
    ShadowChoreographer.setFrameDelay(Duration.ofMillis(16))
}

/** Pumps until something holds; fails after some seconds of the real clock. */
internal fun until(what: String, seconds: Int = 60, holds: () -> Boolean) {
    val end = System.nanoTime() + seconds * 1_000_000_000L
    while (!holds()) {
        if (System.nanoTime() > end) fail("waited $seconds s in vain until $what")
        pump()
    }
}

internal fun Activity.view(id: Int): View = findViewById(id)

internal fun Activity.isShown(id: Int) = view(id).isShown

internal fun Activity.text(id: Int) = findViewById<android.widget.TextView>(id).text.toString()

/** Gives the scene's view a size and a surface, as the system does before the first frame. */
internal fun giveSurface(surface: SceneSurface, width: Int, height: Int) {
    surface.surfaceCreated(holder)
    surface.surfaceChanged(holder, 0, width, height)
}

/** The session of this machine only asks whether there is a surface. */
internal val holder: SurfaceHolder by lazy {
    val surface = Surface(SurfaceTexture(0))
    Proxy.newProxyInstance(
        SurfaceHolder::class.java.classLoader, arrayOf(SurfaceHolder::class.java),
    ) { _, method, _ -> if (method.name == "getSurface") surface else null } as SurfaceHolder
}

/** The whole screen: what the session has drawn, the activity's views over it. */
internal fun screenOf(activity: Activity, scene: Bitmap?): Bitmap {
    val decor = activity.window.decorView
    val screen = Bitmap.createBitmap(max(decor.width, 1), max(decor.height, 1), Bitmap.Config.ARGB_8888)
    val canvas = Canvas(screen)
    decor.draw(canvas)
    if (scene == null) return screen
    canvas.drawBitmap(scene, null, android.graphics.Rect(0, 0, screen.width, screen.height), null)
    drawOver(decor, canvas)
    return screen
}

/** The views that lie over the surface, which is a hole in the window. */
private fun drawOver(decor: View, canvas: Canvas) {
    for (id in intArrayOf(R.id.notes, R.id.controls, R.id.hints, R.id.loading)) {
        val view = decor.findViewById<View>(id) ?: continue
        if (!view.isShown) continue
        val at = IntArray(2)
        view.getLocationInWindow(at)
        canvas.save()
        canvas.translate(at[0].toFloat(), at[1].toFloat())
        view.draw(canvas)
        canvas.restore()
    }
}

internal fun keep(screen: Bitmap, name: String) {
    screens.mkdirs()
    File(screens, "$name.png").outputStream().use { screen.compress(Bitmap.CompressFormat.PNG, 100, it) }
}

internal fun imageOf(name: String): Bitmap = BitmapFactory.decodeFile(File(material, name).path)

/** Peak signal-to-noise ratio of 8-bit colours, dB; 99 for the same image. */
internal fun psnr(a: Bitmap, b: Bitmap): Double {
    require(a.width == b.width && a.height == b.height) {
        "${a.width}x${a.height} is not ${b.width}x${b.height}"
    }
    var squares = 0.0
    for (y in 0 until a.height) for (x in 0 until a.width) {
        val p = a.getPixel(x, y)
        val q = b.getPixel(x, y)
        for (shift in intArrayOf(0, 8, 16)) {
            val d = (p shr shift and 255) - (q shr shift and 255)
            squares += d * d
        }
    }
    return if (squares == 0.0) 99.0
    else 10 * log10(255.0 * 255.0 * 3 * a.width * a.height / squares)
}

/** How different the colours of an image are: 0 for a plain one. */
internal fun spread(image: Bitmap): Int {
    var low = 255
    var high = 0
    for (y in 0 until image.height step 7) for (x in 0 until image.width step 7) {
        val green = image.getPixel(x, y) shr 8 and 255
        low = minOf(low, green)
        high = maxOf(high, green)
    }
    return high - low
}

internal fun <A : Activity> ActivityController<A>.end() {
    pause().stop().destroy()
}

/** Puts bytes into a pipe. Opened for writing only, it would be waited for who reads, who may have left. */
internal fun fill(pipe: File, bytes: ByteArray) = RandomAccessFile(pipe, "rw").use { it.write(bytes) }

/** Another app that keeps scenes: content://documents/NAME, by its [answers]. */
class Documents : ContentProvider() {
    override fun onCreate() = true

    override fun openFile(uri: Uri, mode: String): ParcelFileDescriptor =
        (answers[uri.lastPathSegment] ?: throw FileNotFoundException(uri.toString()))()

    override fun query(
        uri: Uri, columns: Array<String>?, selection: String?, arguments: Array<String>?,
        order: String?,
    ): Cursor {
        if (uri.lastPathSegment == "rude") throw IllegalStateException("no")
        return MatrixCursor(arrayOf(OpenableColumns.DISPLAY_NAME, OpenableColumns.SIZE)).apply {
            addRow(arrayOf<Any?>("My ${uri.lastPathSegment}", sizes[uri.lastPathSegment]))
        }
    }

    override fun getType(uri: Uri) = "application/octet-stream"

    override fun insert(uri: Uri, values: ContentValues?): Uri? = null

    override fun delete(uri: Uri, selection: String?, arguments: Array<String>?) = 0

    override fun update(
        uri: Uri, values: ContentValues?, selection: String?, arguments: Array<String>?,
    ) = 0

    companion object {
        val answers = mutableMapOf<String, () -> ParcelFileDescriptor>()

        /** What it says of the size of those. */
        val sizes = mutableMapOf<String, Long>()

        fun install() {
            Robolectric.setupContentProvider(Documents::class.java, "documents")
        }

        fun uri(name: String): Uri = Uri.parse("content://documents/$name")

        fun offer(file: File): Uri {
            answers[file.name] = {
                ParcelFileDescriptor.open(file, ParcelFileDescriptor.MODE_READ_ONLY)
            }
            return uri(file.name)
        }
    }
}

/** Descriptors of this machine's own, as those that Android hands to native code. */
@Implements(ParcelFileDescriptor::class)
class RealDescriptors : ShadowParcelFileDescriptor() {
    @RealObject
    private lateinit var real: ParcelFileDescriptor

    /** Whoever gets it closes it, and Java must not: the object stays for ever. */
    @Implementation
    fun detachFd(): Int {
        detached += real.fileDescriptor
        return real.fd
    }

    private companion object {
        val detached = mutableListOf<java.io.FileDescriptor>()
    }
}
