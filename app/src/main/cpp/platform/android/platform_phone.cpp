#include <cstddef>

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

// In place of libc++abi's own, which takes a twentieth of the library to write the type of an
// uncaught exception in words into the log; c++filt does so too.
// NOLINTNEXTLINE(bugprone-reserved-identifier): the name is the C++ ABI's
extern "C" char* __cxa_demangle(const char*, char*, std::size_t*, int* status) {
  constexpr int kNoMemory = -1;
  if (status != nullptr) *status = kNoMemory;
  return nullptr;
}
