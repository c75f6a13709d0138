// The part of Android's header that the screen of a phone uses, for the mock in mock_egl.h.
#pragma once

#include <cstdint>

struct ANativeWindow;

extern "C" {
void ANativeWindow_release(ANativeWindow* window);
std::int32_t ANativeWindow_setBuffersGeometry(ANativeWindow* window, std::int32_t width,
                                              std::int32_t height, std::int32_t format);
}
