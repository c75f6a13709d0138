package org.fluxgs.app

import java.io.File
import javax.xml.parsers.DocumentBuilderFactory
import org.junit.Assert.assertEquals
import org.junit.Assert.assertTrue
import org.junit.Test
import org.junit.runner.RunWith
import org.junit.runners.JUnit4
import org.w3c.dom.Element

/** What the app says, in every language: read from the sources. */
@RunWith(JUnit4::class)
class StringsTest {
    private val sources = File("app/src/main")
    private val all = listOf(sources, File("app/src/net"))

    private class Said(val kind: String, val forms: Map<String, String>)

    private fun elements(file: File, name: String): List<Element> {
        val nodes = DocumentBuilderFactory.newInstance().newDocumentBuilder().parse(file).getElementsByTagName(name)
        return (0 until nodes.length).map { nodes.item(it) as Element }
    }

    /** By names: texts have one form, plurals and lists several. */
    private fun texts(sources: File, folder: String): Map<String, Said> {
        val file = File(sources, "res/$folder/strings.xml")
        return listOf("string", "plurals", "string-array").flatMap { kind ->
            elements(file, kind).filter { it.getAttribute("translatable") != "false" }.map { element ->
                val items = element.getElementsByTagName("item")
                val forms = (0 until items.length).map { items.item(it) as Element }.withIndex()
                    .associate { (i, item) -> item.getAttribute("quantity").ifEmpty { "$i" } to item.textContent }
                element.getAttribute("name") to Said(kind, forms.ifEmpty { mapOf("" to element.textContent) })
            }
        }.toMap()
    }

    private val languages = File(sources, "res").list()!!
        .filter { File(sources, "res/$it/strings.xml").exists() && it != "values" }

    private fun arguments(text: String) =
        Regex("""%(\d+\$)?[-#+ 0,(]*\d*(\.\d+)?[a-zA-Z]""").findAll(text).map { it.value }.filter { "$" in it }.toSet()

    @Test
    fun thereAreFiveLanguagesBesideEnglish() {
        assertEquals(setOf("values-de", "values-es", "values-fr", "values-ja", "values-zh-rCN"), languages.toSet())
    }

    @Test
    fun everyLanguageHasEveryTextWithTheSameArguments() = all.forEach { sources ->
        val english = texts(sources, "values")
        for (language in languages) {
            val here = texts(sources, language)
            assertEquals(language, english.keys.sorted(), here.keys.sorted())
            for ((name, said) in here) {
                val original = english.getValue(name)
                assertEquals("$language $name", original.kind, said.kind)
                if (said.kind == "string-array") assertEquals("$language $name", original.forms.size, said.forms.size)
                if (said.kind == "plurals") assertTrue("$language $name", "other" in said.forms)
                val wanted = arguments(original.forms.values.last())
                for (form in said.forms.values) {
                    assertTrue("$language $name is empty", form.isNotBlank())
                    assertEquals("$language $name: $form", wanted, arguments(form))
                    assertTrue("$language $name: an apostrophe ends a text", !Regex("""(?<!\\)'""").containsMatchIn(form))
                }
            }
        }
    }

    @Test
    fun nothingIsSaidThatIsNotInTheResources() {
        for (folder in listOf("layout", "menu")) for (file in File(sources, "res/$folder").listFiles()!!) {
            for (element in elements(file, "*")) for (name in listOf("text", "title", "hint", "contentDescription", "label")) {
                val said = element.getAttribute("android:$name")
                assertTrue("${file.name}: $said", said.isEmpty() || said.startsWith("@string/"))
            }
        }
        for (file in all.flatMap { File(it, "java/org/fluxgs/app").listFiles()!!.asList() }) for (line in file.readLines()) {
            if (isForMachines(line)) continue
            for (text in Regex(""""((?:[^"\\]|\\.)*)"""").findAll(line).map { it.groupValues[1] })
                assertTrue("${file.name} says '$text'", !Regex("""[A-Za-z]{2,} [a-z]{2,}""").containsMatchIn(text))
        }
    }

    /** Comments, the log, and what a shell that gives wrong arguments reads. */
    private fun isForMachines(line: String) =
        Regex("""^\s*(\*|/\*|//)|Log\.|require|throw |@Deprecated|@Suppress|DIED =|FAILED =|ENOSPC""").containsMatchIn(line) ||
            listOf("is not inside of", "is no number from", "is not WIDTHxHEIGHT").any { it in line }

    @Test
    fun noTextIsThereForNobody() {
        val uses = all.asSequence().flatMap { it.walk() }.filter { it.extension in setOf("kt", "xml") && it.name != "strings.xml" }
            .joinToString("\n") { it.readText() }
        for (name in all.flatMap { texts(it, "values").keys })
            assertTrue("nobody says $name", Regex("""(R\.(string|plurals|array)\.|@string/)$name\b""").containsMatchIn(uses))
    }
}
