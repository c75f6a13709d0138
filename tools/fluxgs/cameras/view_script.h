// Reads scripts of window events, for tests and for reports of mistakes.
#pragma once

#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "platform/host/window_screen.h"

namespace fluxgs::cli {

/// To happen before a step is drawn: an event; or a new size of the window if that is not 0×0; or
/// the loss of the graphics context, as when the GPU is reset.
struct ScriptedEvent {
  int step = 0;  ///< ≥ 0
  viewer::WindowEvent event;
  host::WindowSize resize;
  bool lose_context = false;
};

/// The duration of a step, seconds.
inline constexpr double kScriptStep = 1.0 / 60;

/// A JSON list, in the order of "step" (an integer), of
///   {"step", "move": [x, y]}                            the pointer, in px from the top left
///   {"step", "button": "left", "down": true, "at": [x, y]}        (or "middle", "right")
///   {"step", "scroll": notches, "at": [x, y]}
///   {"step", "key": "W", "down": true}                  a key that is held, or "Escape"
///   {"step", "type": "f"}                               a character
///   {"step", "resize": [width, height]}
///   {"step", "lose_context": true}
/// Errors name the file, the entry and what was expected.
Expected<std::vector<ScriptedEvent>> read_view_script(const std::string& path);

}  // namespace fluxgs::cli
