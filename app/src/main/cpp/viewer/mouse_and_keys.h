// Mouse and keys of a desktop: they turn, move and zoom the scene, and fly through it.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "camera/navigation.h"
#include "viewer/window_event.h"

namespace fluxgs::viewer {

/// One line for each thing that can be done, for help texts.
inline constexpr std::string_view kMouseAndKeysHelp =
    "  left drag    turn around the scene (while flying: look around)\n"
    "  right drag   move along the image (or middle drag)\n"
    "  wheel        zoom about the pointer\n"
    "  double click look at what is there, from nearer\n"
    "  W A S D      fly forward, left, back, right; Q E: down, up\n"
    "  + -          fly faster, slower\n"
    "  O            auto-orbit until a click\n"
    "  F            turn the scene upside down\n"
    "  R            reset the view\n";

/// The buttons and keys that are down.
struct MouseAndKeys {
  glm::dvec2 pointer{0.0};
  std::optional<PointerButton> dragging;
  camera::PointerTrail trail;
  double last_press = -1e9;  ///< of the left button, seconds
  glm::dvec2 last_press_at{0.0};
  std::array<bool, 26> letters{};  ///< 'A' to 'Z': keys that are down
};

/// Moves the view. Returns the pixel to look at after a double click. `seconds` since some start,
/// `size` of the window in pixels.
std::optional<glm::dvec2> apply(const WindowEvent& event, double seconds, const glm::dvec2& size,
                                MouseAndKeys& input, camera::Navigation& navigation);

}  // namespace fluxgs::viewer
