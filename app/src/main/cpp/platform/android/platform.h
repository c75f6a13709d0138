// Differences between a phone and a Java machine on the desktop.
#pragma once

#include <jni.h>

#include <memory>

#include "viewer/screen.h"

namespace fluxgs::android {

std::unique_ptr<viewer::Screen> make_screen();

/// What Screen::attach() takes, of an android.view.Surface; null where it is not valid any more.
void* window_of(JNIEnv* env, jobject surface);

/// Where the program runs: "android" or "host".
extern const char* const kPlatform;

}  // namespace fluxgs::android
