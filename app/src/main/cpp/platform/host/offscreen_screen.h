// The screen of a session on a machine without one: images stay where they are drawn.
#pragma once

#include <memory>

#include "platform/host/host_context.h"
#include "viewer/screen.h"

namespace fluxgs::host {

/// Any handle but null counts as a window.
std::unique_ptr<viewer::Screen> make_offscreen_screen(HostGl implementation);

}  // namespace fluxgs::host
