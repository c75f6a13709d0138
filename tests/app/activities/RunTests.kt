package org.fluxgs.app

import java.util.concurrent.TimeUnit
import kotlin.system.exitProcess
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

            override fun testStarted(test: Description) {
                broken = null
                notMet = null
                since = System.nanoTime()
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

            override fun testFinished(test: Description) = tell(test, broken)

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
        exitProcess(0) // FAILED lines are counted by the caller
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
