package org.fluxgs.app

import android.graphics.SurfaceTexture
import android.os.ParcelFileDescriptor
import android.view.Surface
import java.io.File
import org.json.JSONObject
import org.junit.Assert.assertEquals
import org.junit.Assert.assertNull
import org.junit.Assert.assertThrows
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode

/** The native functions turn away what is wrong with exceptions of Java. */
@RunWith(RobolectricTestRunner::class)
@Config(shadows = [RealDescriptors::class])
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class NativeTest {
    private fun inSession(work: (Long) -> Unit) {
        val session = Native.create()
        try {
            work(session)
        } finally {
            Native.destroy(session)
        }
    }

    private fun assertWrong(work: () -> Unit) {
        assertThrows(IllegalArgumentException::class.java) { work() }
    }

    @Test
    fun sessionsThatAreNotThere() {
        val gone = Native.create()
        Native.destroy(gone)
        for (session in longArrayOf(0, -1, Long.MAX_VALUE, gone)) {
            assertThrows(IllegalStateException::class.java) { Native.state(session) }
            assertThrows(IllegalStateException::class.java) { Native.destroy(session) }
            assertThrows(IllegalStateException::class.java) { Native.frame(session, 0) }
            assertThrows(IllegalStateException::class.java) { Native.image(session, 0, 0) }
            assertThrows(IllegalStateException::class.java) { Native.surfaceDestroyed(session) }
        }
    }

    @Test
    fun arraysOfTheWrongLength() = inSession { session ->
        assertWrong { Native.touch(session, 0, 0, intArrayOf(0), floatArrayOf(1f), 0) }
        assertWrong { Native.touch(session, 4, 0, intArrayOf(0), floatArrayOf(1f, 1f), 0) }
        assertWrong { Native.load(session, -1, "a", -1, 1L shl 30, doubleArrayOf(1.0)) }
        assertWrong { Native.startBenchmark(session, intArrayOf(1), 0, 1, true, true, 1) }
        assertWrong { Native.startBenchmark(session, intArrayOf(0, 5), 0, 1, true, true, 1) }
        assertWrong { Native.startBenchmark(session, intArrayOf(5, 5), 0, 0, true, true, 1) }
        assertWrong { Native.startBenchmark(session, intArrayOf(5, 5), 0, 1, true, true, 65) }
    }

    @Test
    fun settingsOutOfTheirRange() = inSession { session ->
        assertWrong { Native.set(session, 2f, 1f, 0, 3, 0, false, true, 0.016f, 0, 0) }
        assertWrong { Native.set(session, Float.NaN, 1f, 0, 3, 0, false, true, 0.016f, 0, 0) }
        assertWrong { Native.set(session, 1f, 0f, 0, 3, 0, false, true, 0.016f, 0, 0) }
        assertWrong { Native.set(session, 1f, 1f, 3, 3, 0, false, true, 0.016f, 0, 0) }
    }

    @Test
    fun pathsVideosAndEventsThatAreNone() = inSession { session ->
        assertWrong { Native.pathThrough(session, DoubleArray(0), true, 1.0) }
        assertWrong { Native.pathThrough(session, doubleArrayOf(1.0), true, 1.0) }
        assertWrong { Native.pathThrough(session, DoubleArray(24), true, 1.0) }
        assertWrong { Native.pathOf(session, ByteArray(0)) }
        assertWrong { Native.goTo(session, DoubleArray(3)) }
        assertThrows(IllegalStateException::class.java) { Native.pathAround(session, 1.0) }
        val surface = Surface(SurfaceTexture(0))
        assertWrong { Native.startVideo(session, surface, 0, 36, 30.0) }
        assertWrong { Native.startVideo(session, surface, 64, 9000, 30.0) }
        assertWrong { Native.startVideo(session, surface, 64, 36, Double.NaN) }
        assertWrong { Native.windowEvent(session, 6, 0f, 0f, 0, false, 0f, 0, 0) }
        assertWrong { Native.windowEvent(session, 1, 0f, 0f, 3, false, 0f, 0, 0) }
        assertWrong { Native.windowEvent(session, 3, 0f, 0f, 0, true, 0f, 128, 0) }
        Native.windowEvent(session, 0, Float.NaN, 0f, 0, false, 0f, 0, 0)
        Native.stick(session, Float.NaN, 5f)
        Native.play(session, true)
        Native.startVideo(session, surface, 64, 36, 30.0)
        until("there is no scene") { "scene" in JSONObject(Native.video(session)).getString("error") }
    }

    @Test
    fun numbersThatAreNone() = inSession { session ->
        val nan = Float.NaN
        Native.surfaceCreated(session, Surface(SurfaceTexture(0)))
        Native.surfaceChanged(session, -5, 0, nan)
        Native.touch(session, 0, 7, intArrayOf(1), floatArrayOf(nan, nan), -1)
        Native.touch(session, 1, 7, intArrayOf(1), floatArrayOf(Float.POSITIVE_INFINITY, 1f), 9)
        Native.turn(session, nan, nan, nan, nan, 99, Long.MIN_VALUE)
        Native.setHeat(session, -7, nan)
        repeat(5) { Native.frame(session, it * 16_000_000L) }
        until("nothing is there to be drawn") { !Native.frame(session, 99 * 16_000_000L) }
        JSONObject(Native.state(session))
        assertNull(Native.image(session, -3, 0))
        assertEquals("", Native.driver(session))
    }

    @Test
    fun aDescriptorThatIsClosed() = inSession { session ->
        Native.load(session, 123456, "none", -1, 1L shl 30, null)
        until("it has failed") {
            JSONObject(Native.state(session)).getJSONObject("loading").getString("phase") == "failed"
        }
    }

    @Test
    fun manySessionsAtOnce() {
        val sessions = LongArray(20) { Native.create() }
        assertEquals(20, sessions.toSet().size)
        sessions.forEach { Native.destroy(it) }
    }

    @Test
    fun theSelfTestIsOfTheSceneThatIsLoaded() = inSession { session ->
        assertThrows(IllegalStateException::class.java) { Native.selfTest(session) }
        val file = ParcelFileDescriptor.open(File(material, "scene.spz"), ParcelFileDescriptor.MODE_READ_ONLY)
        Native.load(session, file.detachFd(), "scene.spz", -1, 1L shl 30, null)
        until("it is loaded") {
            JSONObject(Native.state(session)).getJSONObject("loading").getString("phase") == "ready"
        }
        assertEquals(28842, JSONObject(Native.selfTest(session)).getInt("splats"))
    }

    @Test
    fun namesOfAnyLanguage() = inSession { session ->
        val name = "Küche \uD83C\uDF73 台所.glb"
        Native.load(session, 123456, name, -1, 1L shl 30, null)
        until("it has failed") {
            val loading = JSONObject(Native.state(session)).getJSONObject("loading")
            loading.getString("phase") == "failed" && loading.getString("error").contains(name)
        }
    }

    @Test
    fun whatItIs() {
        val about = JSONObject(Native.about())
        assertEquals("host", about.getString("platform"))
        assertEquals("host", about.getString("build"))
    }
}
