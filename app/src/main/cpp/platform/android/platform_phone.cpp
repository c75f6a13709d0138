#include <android/native_window_jni.h>

#include "platform/android/egl_screen.h"
#include "platform/android/platform.h"

namespace fluxgs::android {

const char* const kPlatform = "android";

std::unique_ptr<viewer::Screen> make_screen() { return make_egl_screen(); }

void* window_of(JNIEnv* env, jobject surface) {
  return surface != nullptr ? ANativeWindow_fromSurface(env, surface) : nullptr;
}

}  // namespace fluxgs::android
