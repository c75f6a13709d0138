// Events of a desktop's window: the mouse, the keys, and whether the window must be drawn again.
#pragma once

#include <glm/vec2.hpp>

namespace fluxgs::viewer {

enum class PointerButton { left, middle, right };

/// Escape as WindowEvent::key. Other keys are the capital letter or the digit that they have on a
/// US keyboard, so that they lie in the same places on every keyboard.
inline constexpr char kEscape = 27;

struct WindowEvent {
  enum class Kind {
    pointer_moved,  ///< position
    button,         ///< button, down, position
    scrolled,       ///< amount: notches, away from the user > 0; position
    key,            ///< key, down
    text,           ///< key: an ASCII character that was typed, whatever the keyboard
    focus_lost,     ///< keys that are down will not be reported as lifted
    uncovered,      ///< the window's content must be drawn again
  };
  Kind kind = Kind::uncovered;
  glm::dvec2 position{0.0};  ///< px of the framebuffer, from its top left corner
  PointerButton button = PointerButton::left;
  bool down = false;
  double amount = 0;
  char key = 0;
};

}  // namespace fluxgs::viewer
