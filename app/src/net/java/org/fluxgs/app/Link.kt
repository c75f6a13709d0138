package org.fluxgs.app

import android.content.Context
import android.net.Uri
import android.os.CancellationSignal
import java.io.BufferedInputStream
import java.io.FilterInputStream
import java.io.IOException
import java.io.InputStream
import java.net.HttpURLConnection
import java.net.MalformedURLException
import java.net.SocketTimeoutException
import java.net.URL
import java.net.UnknownHostException
import javax.net.ssl.SSLException

/** A scene behind a link, at most [most] bytes of it. */
internal class Link(
    private val context: Context, override val uri: Uri, private val most: Long = MOST_BYTES,
) : SceneSource {
    override val name = uri.lastPathSegment ?: uri.host.orEmpty()
    override val origin: String = context.getString(R.string.link_from, uri.host.orEmpty())
    override val isFixed = true

    override fun open(signal: CancellationSignal): SceneSource.Stream {
        var url = URL(Uri.encode(uri.toString(), LINK_CHARACTERS))
        repeat(MOST_REDIRECTS) {
            val connection = connect(url)
            signal.setOnCancelListener { connection.disconnect() }
            if (connection.responseCode !in REDIRECTS) return streamOf(connection)
            url = URL(url, connection.getHeaderField("Location") ?: "")
            connection.disconnect()
        }
        throw problem(R.string.link_redirects)
    }

    private fun connect(url: URL): HttpURLConnection {
        if (url.protocol == "http") throw problem(R.string.link_insecure)
        if (url.protocol != "https" || url.host.isEmpty()) throw problem(R.string.link_broken)
        return connections(url).apply {
            instanceFollowRedirects = false // they may lead away from https
            connectTimeout = PATIENCE_MS
            readTimeout = PATIENCE_MS
            setRequestProperty("Accept-Encoding", "identity") // so that its length is that of the file
        }
    }

    private fun streamOf(connection: HttpURLConnection): SceneSource.Stream {
        val code = connection.responseCode
        if (code != HttpURLConnection.HTTP_OK) throw SceneSource.Problem(context.getString(wordsFor(code), code))
        val type = connection.contentType.orEmpty()
        val bytes = connection.contentLengthLong
        if (bytes > most) throw tooLarge()
        val input = BufferedInputStream(Limited(connection.inputStream))
        val first = SceneBytes.first(input)
        val page = PAGE_TYPES.any { type.startsWith(it, ignoreCase = true) } || isPage(first)
        if (!page && SceneBytes.mayBe(first, name)) return SceneSource.Stream(input, bytes)
        connection.disconnect()
        throw problem(if (page) R.string.link_to_page else R.string.scene_broken)
    }

    private fun isPage(first: ByteArray) =
        String(first).trimStart('\uFEFF', ' ', '\t', '\r', '\n').startsWith("<")

    private fun wordsFor(code: Int) = when (code) {
        404, 410 -> R.string.link_gone
        401, 402, 403, 451 -> R.string.link_forbidden
        else -> R.string.link_refused
    }

    override fun wordsFor(problem: IOException): String = when (problem) {
        is MalformedURLException -> context.getString(R.string.link_broken)
        is UnknownHostException -> context.getString(R.string.link_no_server, uri.host)
        is SSLException -> context.getString(R.string.link_not_secure, uri.host)
        is SocketTimeoutException -> context.getString(R.string.link_stalled)
        else -> context.getString(R.string.link_cut)
    }

    private fun problem(words: Int) = SceneSource.Problem(context.getString(words))

    private fun tooLarge() = SceneSource.Problem(context.getString(R.string.link_too_large, Texts.size(context, most)))

    /** Of a server that has not said how much it sends, or sends for ever. */
    private inner class Limited(input: InputStream) : FilterInputStream(input) {
        private var left = most

        override fun read(): Int = super.read().also { if (it >= 0) count(1) }

        override fun read(bytes: ByteArray, offset: Int, length: Int): Int =
            super.read(bytes, offset, length).also { count(it.coerceAtLeast(0)) }

        private fun count(bytes: Int) {
            left -= bytes
            if (left < 0) throw tooLarge()
        }
    }

    companion object {
        const val MOST_BYTES = 4L shl 30
        private const val MOST_REDIRECTS = 6
        private const val PATIENCE_MS = 30_000
        private const val LINK_CHARACTERS = "-._~:/?#[]@!$&'()*+,;=%"
        private val REDIRECTS = setOf(301, 302, 303, 307, 308)
        private val PAGE_TYPES = listOf("text/html", "application/xhtml")

        /** Opens a connection to an https address. */
        var connections: (URL) -> HttpURLConnection = { it.openConnection() as HttpURLConnection }

        /** The first link in a text, as it is shared. */
        fun find(text: String): Uri? =
            Regex("""https?://\S+""", RegexOption.IGNORE_CASE).find(text)?.value
                ?.trimEnd('.', ',', ';', ':', '!', '?', ')', ']', '}', '>', '"', '\'', '”', '’', '»')
                ?.let { Uri.parse(it).normalizeScheme() }
    }
}
