// Which mouse movement and which key does what in fluxgs view.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "camera/navigation.h"
#include "platform/host/window.h"

namespace fluxgs::cli {

/// One line each, for --help and the start.
inline constexpr std::string_view kViewKeys =
    "  left drag    turn around the scene (while flying: look around)\n"
    "  right drag   move along the image (or middle drag)\n"
    "  wheel        zoom about the pointer\n"
    "  double click look at what is there, from nearer\n"
    "  W A S D      fly forward, left, back, right; Q E: down, up\n"
    "  + -          fly faster, slower\n"
    "  F            turn the scene upside down\n"
    "  R            back to the first view\n"
    "  P            print the camera, as --camera takes it\n"
    "  Escape       close\n";

/// What is pressed.
struct ViewInput {
  glm::dvec2 pointer{0.0};
  std::optional<host::PointerButton> dragging;
  camera::PointerTrail trail;
  double last_press = -1e9;  ///< of the left button, seconds
  glm::dvec2 last_press_at{0.0};
  std::array<bool, 26> letters{};  ///< 'A' to 'Z': keys that are down
};

/// What is left to the viewer.
struct ViewRequest {
  std::optional<glm::dvec2> focus;  ///< the pixel to look at
  bool quit = false, print_camera = false;
};

/// `time` in seconds since some start, `size` of the window in pixels.
ViewRequest apply(const host::WindowEvent& event, double time, const glm::dvec2& size,
                  ViewInput& input, camera::Navigation& navigation);

}  // namespace fluxgs::cli
