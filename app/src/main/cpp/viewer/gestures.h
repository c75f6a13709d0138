// Fingers on a screen: one turns the scene, two move, zoom and roll it, a double tap looks closer.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "camera/navigation.h"

namespace fluxgs::viewer {

/// One that touches the screen. Positions in pixels, from the top left corner of the view.
struct Finger {
  int id = 0;  ///< stays the same until it is lifted
  glm::dvec2 position{0.0};
};

enum class TouchPhase { down, moved, up, cancelled };

/// An event as the system reports it: all fingers that touch, the one that goes down or up
/// included.
struct TouchEvent {
  TouchPhase phase = TouchPhase::moved;
  int changed = 0;  ///< the finger that goes down or up
  std::span<const Finger> fingers;
  double seconds = 0;  ///< since some start
};

struct GestureOptions {
  double density = 1;           ///< px of a dp, which is 1/160 inch: a finger has a size
  double slop = 8;              ///< dp that a tap may move
  double longest_tap = 0.3;     ///< s
  double double_tap = 0.3;      ///< s between the taps
  double double_tap_slop = 40;  ///< dp between them
};

struct Gestures {
  GestureOptions options;
  camera::DragAction one_finger = camera::DragAction::orbit;

  std::vector<Finger> fingers;  ///< that touch, in the order in which they came down
  camera::PointerTrail trail;   ///< of a single finger
  bool tapping = false;         ///< one finger, so far short and still
  double pressed = 0;
  glm::dvec2 pressed_at{0.0};
  std::optional<double> tapped;  ///< when the last tap ended
  glm::dvec2 tapped_at{0.0};
};

/// Moves the view. Returns the pixel to look at after a double tap. `size` of the view, pixels.
/// Fingers that were never told of coming down are ignored.
std::optional<glm::dvec2> apply(const TouchEvent& event, const glm::dvec2& size, Gestures& gestures,
                                camera::Navigation& navigation);

}  // namespace fluxgs::viewer
