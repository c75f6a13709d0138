package org.fluxgs.app

import android.app.AlertDialog
import android.content.ContentProvider
import android.content.ContentValues
import android.content.DialogInterface
import android.content.Intent
import android.database.Cursor
import android.graphics.SurfaceTexture
import android.net.Uri
import android.os.Build
import android.os.Environment
import android.os.ParcelFileDescriptor
import android.provider.MediaStore
import android.util.Size
import android.view.Surface
import java.io.File
import java.io.FileDescriptor
import java.io.FileOutputStream
import java.io.IOException
import org.junit.After
import org.junit.Assert.assertEquals
import org.junit.Assert.assertFalse
import org.junit.Assert.assertNull
import org.junit.Assert.assertTrue
import org.junit.Before
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import org.robolectric.shadows.ShadowDialog
import org.robolectric.shadows.ShadowPopupMenu
import org.robolectric.shadows.ShadowStatFs
import org.robolectric.shadows.ShadowToast

/** Videos for the gallery, with an encoder and a gallery that are played. */
@RunWith(RobolectricTestRunner::class)
@Config(qualifiers = "w640dp-h480dp-land-mdpi", shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class VideoTest : ViewerScreen() {
    /** Writes a text in place of a video. */
    private inner class PlayedEncoder(file: FileDescriptor, val size: Size, val fps: Int, val fail: () -> Unit) : VideoEncoder {
        private val stream = FileOutputStream(file)
        override val surface = Surface(SurfaceTexture(0))
        var closed = false

        override fun finish() {
            problem?.let { throw IOException(it) }
            stream.write("whole".toByteArray())
        }

        override fun close() {
            closed = true
        }
    }

    private var encoder: PlayedEncoder? = null
    private var problem: String? = null
    private val real = VideoEncoder.open to VideoEncoder.sizeFor

    @Before
    fun play() {
        Media.files.clear()
        Robolectric.setupContentProvider(Media::class.java, "media")
        room(1 shl 20)
        VideoEncoder.sizeFor = { upright -> if (upright) Size(36, 64) else Size(64, 36) }
        VideoEncoder.open = { file, size, fps, fail -> PlayedEncoder(file, size, fps, fail).also { encoder = it } }
    }

    @After
    fun restore() {
        VideoEncoder.open = real.first
        VideoEncoder.sizeFor = real.second
    }

    private fun room(blocks: Int) =
        ShadowStatFs.registerStats(Environment.getExternalStorageDirectory(), blocks, blocks, blocks)

    /** Chooses it in the menu, and starts it as it is proposed. */
    private fun start() {
        press(R.id.motion)
        ShadowPopupMenu.getLatestPopupMenu().menu.performIdentifierAction(R.string.save_video, 0)
        pump()
        button(DialogInterface.BUTTON_POSITIVE)
    }

    private fun button(which: Int) {
        (ShadowDialog.getLatestDialog() as AlertDialog).getButton(which).performClick()
        pump()
    }

    private fun said() = ShadowToast.getTextOfLatestToast() ?: ""

    private fun isRunning() = session.video()!!.getBoolean("running")

    private fun nothingIsLeft() {
        assertTrue(encoder == null || encoder!!.closed)
        assertEquals(emptyMap<Uri, Media.Entry>(), Media.files)
        assertNull(SharedFiles.folder(context).listFiles()!!.find { it.name.endsWith("mp4") })
        settled() // and the scene is drawn on
    }

    @Test
    fun aVideoGoesToTheGallery() {
        openAndDraw()
        val before = session.place()!!
        start()
        until("it is whole", 200) { encoder?.closed == true } // 300 frames
        assertEquals(300, session.video()!!.getInt("done"))
        assertEquals(Size(64, 36), encoder!!.size)
        assertEquals(30, encoder!!.fps)
        assertTrue(before.contentEquals(session.place()!!))
        if (Build.VERSION.SDK_INT < 29) {
            assertEquals(Intent.ACTION_CHOOSER, started().action)
            return
        }
        until("it is said") { said() == context.getString(R.string.video_saved) }
        val entry = Media.files.values.single()
        assertEquals("whole", entry.file.readText())
        assertFalse(entry.pending)
        assertTrue(entry.name, entry.name.endsWith(".mp4"))
    }

    @Test
    fun oneThatIsCancelledLeavesNothing() {
        openAndDraw()
        start()
        until("it is being made") { encoder != null && isRunning() && session.video()!!.getInt("done") > 2 }
        button(DialogInterface.BUTTON_NEGATIVE)
        until("it has ended") { encoder!!.closed && !isRunning() }
        until("its file is gone") { Media.files.isEmpty() } // which comes after the encoder
        pump(500)
        assertEquals("", said())
        nothingIsLeft()
    }

    @Test
    fun leavingTheAppEndsIt() {
        openAndDraw()
        start()
        until("it is being made") { encoder != null && isRunning() }
        controller!!.pause().stop()
        until("it is said") { context.getString(R.string.stopped_by_leaving) in said() }
        controller!!.restart().start().resume()
        nothingIsLeft()
    }

    @Test
    fun anEncoderThatFailsLeavesNothing() {
        problem = "broken"
        openAndDraw()
        start()
        until("it is being made") { encoder != null && isRunning() }
        encoder!!.fail()
        until("it is said") { "broken" in said() }
        nothingIsLeft()
    }

    @Test
    fun aFullDiskIsSaidPlainly() {
        room(1)
        openAndDraw()
        start()
        until("it is said") { context.getString(R.string.video_no_room) in said() }
        assertNull(encoder)
        nothingIsLeft()
    }

    @Test
    fun theTimeLeftIsThatOfTheFramesSoFar() {
        assertNull("too few", VideoExport.secondsLeft(5000, 4, 100))
        assertNull("too soon", VideoExport.secondsLeft(900, 50, 100))
        assertEquals(30L, VideoExport.secondsLeft(10_000, 25, 100))
        assertEquals(0L, VideoExport.secondsLeft(10_000, 100, 100))
    }
}

/** The gallery. */
class Media : ContentProvider() {
    class Entry(val file: File, val name: String, var pending: Boolean)

    override fun onCreate() = true

    override fun insert(uri: Uri, values: ContentValues?): Uri {
        val entry = Uri.withAppendedPath(uri, "${files.size + 1}")
        files[entry] = Entry(
            File.createTempFile("video", ".mp4"), values!!.getAsString(MediaStore.MediaColumns.DISPLAY_NAME),
            values.getAsInteger(MediaStore.MediaColumns.IS_PENDING) == 1,
        )
        return entry
    }

    override fun openFile(uri: Uri, mode: String): ParcelFileDescriptor =
        ParcelFileDescriptor.open(files[uri]!!.file, ParcelFileDescriptor.MODE_READ_WRITE)

    override fun update(uri: Uri, values: ContentValues?, selection: String?, arguments: Array<String>?): Int {
        files[uri]!!.pending = values!!.getAsInteger(MediaStore.MediaColumns.IS_PENDING) == 1
        return 1
    }

    override fun delete(uri: Uri, selection: String?, arguments: Array<String>?): Int {
        files.remove(uri)!!.file.delete()
        return 1
    }

    override fun query(
        uri: Uri, columns: Array<String>?, selection: String?, arguments: Array<String>?, order: String?,
    ): Cursor? = null

    override fun getType(uri: Uri) = VideoFile.TYPE

    companion object {
        val files = mutableMapOf<Uri, Entry>()
    }
}
