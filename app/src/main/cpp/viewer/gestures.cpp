#include "viewer/gestures.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::viewer {
namespace {

const Finger* find(std::span<const Finger> fingers, int id) {
  const auto found = std::ranges::find(fingers, id, &Finger::id);
  return found != fingers.end() ? &*found : nullptr;
}

bool is_finite(const glm::dvec2& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

double distance_dp(const Gestures& g, const glm::dvec2& a, const glm::dvec2& b) {
  return glm::distance(a, b) / g.options.density;
}

/// A single finger begins, or goes on after the other was lifted.
void begin_single(Gestures& g, double seconds) {
  g.trail = {};
  camera::add(g.trail, seconds, g.fingers.front().position);
}

void put_down(const TouchEvent& e, Gestures& g, camera::Navigation& n) {
  const Finger* finger = find(e.fingers, e.changed);
  if (finger == nullptr || find(g.fingers, e.changed) != nullptr) return;
  if (!is_finite(finger->position)) return;
  camera::touch(n);
  g.fingers.push_back(*finger);
  g.tapping = g.fingers.size() == 1;
  if (!g.tapping) return;
  g.pressed = e.seconds;
  g.pressed_at = finger->position;
  begin_single(g, e.seconds);
}

/// The fingers that there were, where they are now.
std::vector<Finger> moved(const TouchEvent& e, const Gestures& g) {
  std::vector<Finger> now = g.fingers;
  for (Finger& finger : now) {
    const Finger* told = find(e.fingers, finger.id);
    if (told != nullptr && is_finite(told->position)) finger.position = told->position;
  }
  return now;
}

void move(const TouchEvent& e, const glm::dvec2& size, Gestures& g, camera::Navigation& n) {
  const std::vector<Finger> now = moved(e, g);
  if (now.empty()) return;
  if (now.size() > 1) {
    n.view = camera::pinch(n.view, {g.fingers[0].position, g.fingers[1].position},
                           {now[0].position, now[1].position}, size, n.units.distances);
    g.fingers = now;
    return;
  }
  if (g.tapping && distance_dp(g, now[0].position, g.pressed_at) <= g.options.slop) return;
  g.tapping = false;
  camera::drag(n, g.one_finger, now[0].position - g.fingers[0].position, size);
  camera::add(g.trail, e.seconds, now[0].position);
  g.fingers = now;
}

/// The point to look at, if it is the second tap.
std::optional<glm::dvec2> tap(const TouchEvent& e, const glm::dvec2& at, Gestures& g) {
  const GestureOptions& o = g.options;
  const bool second = g.tapped && g.pressed - *g.tapped <= o.double_tap &&
                      distance_dp(g, at, g.tapped_at) <= o.double_tap_slop;
  g.tapped = e.seconds;
  g.tapped_at = at;
  if (!second) return std::nullopt;
  g.tapped.reset();
  return at;
}

std::optional<glm::dvec2> lift(const TouchEvent& e, Gestures& g, camera::Navigation& n) {
  const auto lifted = std::ranges::find(g.fingers, e.changed, &Finger::id);
  if (lifted == g.fingers.end()) return std::nullopt;
  const Finger finger = *lifted;
  const bool moving = lifted - g.fingers.begin() < 2;  // a third finger moves nothing
  g.fingers.erase(lifted);
  if (g.fingers.size() == 1 && moving) begin_single(g, e.seconds);
  if (!g.fingers.empty()) return std::nullopt;
  if (g.tapping && e.seconds - g.pressed <= g.options.longest_tap)
    return tap(e, finger.position, g);
  g.tapped.reset();
  if (!g.tapping) camera::release(n, g.one_finger, camera::velocity(g.trail, e.seconds));
  return std::nullopt;
}

}  // namespace

std::optional<glm::dvec2> apply(const TouchEvent& event, const glm::dvec2& size, Gestures& gestures,
                                camera::Navigation& navigation) {
  switch (event.phase) {
    case TouchPhase::down:
      put_down(event, gestures, navigation);
      break;
    case TouchPhase::moved:
      move(event, size, gestures, navigation);
      break;
    case TouchPhase::up:
      return lift(event, gestures, navigation);
    case TouchPhase::cancelled:
      gestures.fingers.clear();
      gestures.tapped.reset();
      break;
  }
  return std::nullopt;
}

}  // namespace fluxgs::viewer
