package org.fluxgs.app

import android.annotation.TargetApi
import android.os.Build
import android.view.View
import android.view.Window
import android.view.WindowInsets
import android.view.WindowInsetsController
import android.view.WindowManager

/** Insets of system bars and display cutouts, and hiding the bars. */
internal object Insets {
    /** Keeps the view's content out from under bars and cameras. */
    fun pad(view: View) {
        val left = view.paddingLeft
        val top = view.paddingTop
        val right = view.paddingRight
        val bottom = view.paddingBottom
        view.setOnApplyWindowInsetsListener { padded, insets ->
            val bars = barsOf(insets)
            padded.setPadding(left + bars[0], top + bars[1], right + bars[2], bottom + bars[3])
            insets
        }
    }

    fun immersive(window: Window) {
        if (Build.VERSION.SDK_INT >= 30) {
            immersive30(window)
        } else {
            @Suppress("DEPRECATION")
            window.decorView.systemUiVisibility = View.SYSTEM_UI_FLAG_IMMERSIVE_STICKY or
                View.SYSTEM_UI_FLAG_FULLSCREEN or View.SYSTEM_UI_FLAG_HIDE_NAVIGATION or
                View.SYSTEM_UI_FLAG_LAYOUT_STABLE or View.SYSTEM_UI_FLAG_LAYOUT_FULLSCREEN or
                View.SYSTEM_UI_FLAG_LAYOUT_HIDE_NAVIGATION
        }
        if (Build.VERSION.SDK_INT >= 28) beside28(window)
    }

    private fun barsOf(insets: WindowInsets): IntArray =
        if (Build.VERSION.SDK_INT >= 30) bars30(insets) else barsBefore30(insets)

    @TargetApi(30)
    private fun bars30(insets: WindowInsets): IntArray {
        val type = WindowInsets.Type.systemBars() or WindowInsets.Type.displayCutout()
        val bars = insets.getInsets(type)
        return intArrayOf(bars.left, bars.top, bars.right, bars.bottom)
    }

    /** Bars that are hidden have no size here, but the cameras below them have. */
    @Suppress("DEPRECATION")
    private fun barsBefore30(insets: WindowInsets): IntArray {
        val bars = intArrayOf(
            insets.systemWindowInsetLeft, insets.systemWindowInsetTop,
            insets.systemWindowInsetRight, insets.systemWindowInsetBottom,
        )
        if (Build.VERSION.SDK_INT < 28) return bars
        val cutout = cutout28(insets)
        return IntArray(4) { maxOf(bars[it], cutout[it]) }
    }

    @TargetApi(28)
    private fun cutout28(insets: WindowInsets): IntArray {
        val cutout = insets.displayCutout ?: return IntArray(4)
        return intArrayOf(
            cutout.safeInsetLeft, cutout.safeInsetTop, cutout.safeInsetRight, cutout.safeInsetBottom,
        )
    }

    @TargetApi(30)
    private fun immersive30(window: Window) {
        window.setDecorFitsSystemWindows(false)
        val controller = window.decorView.windowInsetsController ?: return
        controller.systemBarsBehavior =
            WindowInsetsController.BEHAVIOR_SHOW_TRANSIENT_BARS_BY_SWIPE
        controller.hide(WindowInsets.Type.systemBars())
    }

    @TargetApi(28)
    private fun beside28(window: Window) {
        val attributes = window.attributes
        attributes.layoutInDisplayCutoutMode =
            WindowManager.LayoutParams.LAYOUT_IN_DISPLAY_CUTOUT_MODE_SHORT_EDGES
        window.attributes = attributes
    }
}
