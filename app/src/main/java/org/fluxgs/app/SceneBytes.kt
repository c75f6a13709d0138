package org.fluxgs.app

import java.io.InputStream

/** What the first bytes of a file say of it. The renderer's readers look closer, once it is opened. */
internal object SceneBytes {
    private const val FIRST = 512
    private val MAGICS = listOf("glTF", "ply", "NGSP", "\u001f\u008b", "PK\u0003\u0004") // of .spz two, and of .sog

    /** Leaves them in a stream that can be marked. */
    fun first(input: InputStream): ByteArray {
        input.mark(FIRST)
        val bytes = ByteArray(FIRST)
        var size = 0
        while (size < FIRST) size += input.read(bytes, size, FIRST - size).takeIf { it > 0 } ?: break
        input.reset()
        return bytes.copyOf(size)
    }

    /** A .splat begins with anything: it has its name only. */
    fun mayBe(first: ByteArray, name: String): Boolean {
        val text = String(first, Charsets.ISO_8859_1)
        return MAGICS.any { text.startsWith(it) } || Texts.endingOf(name).isNotEmpty()
    }
}
