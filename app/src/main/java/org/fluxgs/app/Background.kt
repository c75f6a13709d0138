package org.fluxgs.app

import java.util.concurrent.Callable
import java.util.concurrent.Executors
import java.util.concurrent.Future

/**
 * One thread for what takes long and must not hold the main thread up: images and files. What is
 * given to it is done in this order, so that what is written first is read afterwards.
 */
internal object Background {
    private val executor = Executors.newSingleThreadExecutor { work ->
        Thread(work, "background").apply { isDaemon = true }
    }

    /** [work] catches what it may throw: what is thrown is in the result, where few look. */
    fun <T> start(work: () -> T): Future<T> = executor.submit(Callable { work() })
}
