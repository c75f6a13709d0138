// Differences between a phone and a Java machine on the desktop.
#pragma once

#include <jni.h>

#include <memory>

#include "viewer/screen.h"

namespace fluxgs::android {

std::unique_ptr<viewer::Screen> make_screen();

/// Argument of Screen::attach() for an android.view.Surface; null where it is not valid any more.
void* window_of(JNIEnv* env, jobject surface);

/// Name of the platform: "android" or "host".
extern const char* const kPlatform;

}  // namespace fluxgs::android
