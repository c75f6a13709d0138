// The screen of a phone: EGL on an ANativeWindow.
#pragma once

#include <memory>

#include "viewer/screen.h"

namespace fluxgs::android {

/// Windows are ANativeWindow*; one that is attached is released when it is no longer used.
std::unique_ptr<viewer::Screen> make_egl_screen();

}  // namespace fluxgs::android
