// A Java machine on the desktop: the very library of the phone, but for the window, so that its
// shell can be tested with the renderer behind it.
#include "platform/android/platform.h"
#include "platform/host/offscreen_screen.h"

namespace fluxgs::android {

const char* const kPlatform = "host";

std::unique_ptr<viewer::Screen> make_screen() {
  return host::make_offscreen_screen(host::HostGl::egl);
}

void* window_of(JNIEnv*, jobject surface) { return surface; }  // only whether it is null matters

}  // namespace fluxgs::android
