// The screen of a page: a canvas with WebGPU, if the page has made that, or else WebGL 2.
#pragma once

#include <memory>

#include "viewer/screen.h"

namespace fluxgs::web {

/// The canvas is the page's (Module.canvas). After a context of WebGL was lost make_context() fails
/// until the browser has restored it.
std::unique_ptr<viewer::Screen> make_web_screen();

}  // namespace fluxgs::web
