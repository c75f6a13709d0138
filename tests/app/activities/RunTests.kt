package org.fluxgs.app

import java.util.concurrent.Executors
import java.util.concurrent.ScheduledFuture
import java.util.concurrent.TimeUnit
import org.junit.runner.Description
import org.junit.runner.JUnitCore
import org.junit.runner.Request
import org.junit.runner.manipulation.Filter
import org.junit.runner.notification.Failure
import org.junit.runner.notification.RunListener

/** Runs the classes that are named; a line a test as tests/app/checks.sh has them. */
object RunTests {
    @JvmStatic
    fun main(arguments: Array<String>) {
        val only = System.getenv("FLUXGS_ONLY")
        val core = JUnitCore()
        core.addListener(object : RunListener() {
            private var broken: Failure? = null
            private var notMet: Failure? = null
            private var since = 0L
            private val limit = TimeLimit(minutes = 5)

            override fun testStarted(test: Description) {
                broken = null
                notMet = null
                since = System.nanoTime()
                limit.start(nameOf(test))
            }

            override fun testFailure(failure: Failure) {
                broken = failure
                if (failure.description.methodName == null) tell(failure.description, failure)
            }

            override fun testAssumptionFailure(failure: Failure) {
                notMet = failure
            }

            override fun testIgnored(test: Description) =
                println("skipped ${nameOf(test)}: it is switched off")

            override fun testFinished(test: Description) {
                limit.end()
                tell(test, broken)
            }

            private fun tell(test: Description, failure: Failure?) {
                val seconds = TimeUnit.NANOSECONDS.toMillis(System.nanoTime() - since) / 1000.0
                val assumption = notMet
                if (assumption != null) {
                    println("skipped ${nameOf(test)}: ${assumption.message}")
                } else if (failure == null) {
                    println("ok ${nameOf(test)} ($seconds s)")
                } else {
                    println("FAILED ${nameOf(test)}: ${failure.exception.toString().lines().first()}")
                    System.err.println(failure.trace)
                }
            }
        })
        for (name in arguments) {
            val request = Request.aClass(Class.forName(name))
            if (only == null) core.run(request)
            else if (named(only).shouldRun(request.runner.description)) core.run(request.filterWith(named(only)))
        }
        System.out.flush()
        // Not exitProcess(), which waits for threads that draw; FAILED lines are counted by the caller
        Runtime.getRuntime().halt(0)
    }

    private fun named(only: String) = object : Filter() {
        override fun describe() = "those with $only in their names"

        override fun shouldRun(test: Description): Boolean =
            if (test.isTest) only in nameOf(test) else test.children.any { shouldRun(it) }
    }

    private fun nameOf(test: Description) =
        test.testClass.simpleName + (test.methodName?.let { ".$it" } ?: "") +
            " (API ${System.getProperty("fluxgs.api")})"
}

/**
 * Ends the Java machine where one test takes longer than [minutes], many times what any of them takes: the
 * test is told as failed, with what every thread is doing.
 */
private class TimeLimit(private val minutes: Long) {
    private val timer = Executors.newSingleThreadScheduledExecutor {
        Thread(it, "time limit").apply { isDaemon = true }
    }
    private var pending: ScheduledFuture<*>? = null

    fun start(test: String) {
        pending = timer.schedule({ giveUp(test) }, minutes, TimeUnit.MINUTES)
    }

    fun end() {
        pending?.cancel(false)
    }

    private fun giveUp(test: String) {
        println("FAILED $test: did not end within $minutes minutes")
        // The last lines are those that tests/app/run shows: the threads that run tests
        val threads = Thread.getAllStackTraces().toList()
        for ((thread, frames) in threads.sortedBy { (thread, _) -> "main" in thread.name.lowercase() }) {
            System.err.println("${thread.name} (${thread.state})")
            for (frame in frames) System.err.println("    at $frame")
        }
        System.out.flush()
        System.err.flush()
        Runtime.getRuntime().halt(1) // exiting could wait for what hangs
    }
}
