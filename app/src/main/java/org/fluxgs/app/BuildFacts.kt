package org.fluxgs.app

import android.content.Context
import org.json.JSONObject

/** Versions and build settings of this app and of the library inside it. */
internal object BuildFacts {
    val native: JSONObject by lazy { JSONObject(Native.about()) }

    /** True if the library was built for checks only: no compiler that phones should trust. */
    val isCheckBuild get() = native.getString("build") == "check"

    fun version(context: Context): String = packageOf(context).versionName ?: ""

    /** Another text after every installation, also one of the same version. */
    fun installed(context: Context) = "${version(context)} of ${packageOf(context).lastUpdateTime}"

    private fun packageOf(context: Context) =
        context.packageManager.getPackageInfo(context.packageName, 0)
}
