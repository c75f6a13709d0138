#include "camera/navigation.h"

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>

namespace fluxgs::camera {
namespace {

bool is_flying(const FlyDirection& d) { return d.right != 0 || d.up != 0 || d.forward != 0; }

/// Half a turn about the level direction of view: what was down is up, and what was in front stays.
ViewState upside_down(const ViewState& view, const glm::dvec3& up) {
  const glm::dvec3 front = level_direction(view, up);
  const glm::dquat turn(0, front.x, front.y, front.z);
  ViewState result = view;
  result.orientation = glm::normalize(turn * view.orientation);
  return result;
}

void play_on(Navigation& n, double seconds, const glm::dvec2& size) {
  const auto& [path, elapsed] = *n.playback;
  n.playback->elapsed += std::max(seconds, 0.0);
  n.view = view_at(*path, elapsed, size);
  if (is_over(*path, elapsed)) n.playback.reset();
}

void fly_on(Navigation& n, double seconds) {
  constexpr double kWalking = 0.4;  // of the speed of flying
  const double speed = n.units.speed * n.speed_factor;
  if (!n.walking)
    n.view = fly(n.view, n.flying, speed, seconds, n.up);
  else if (!n.transition)
    n.view = walk(n.view, n.flying, kWalking * speed, seconds, *n.walking, n.units, n.up);
}

}  // namespace

Navigation navigation_from(const ViewState& view, const glm::dvec3& up, const SceneUnits& units) {
  Navigation n;
  n.view = n.home = view;
  n.up = up;
  n.units = units;
  return n;
}

void touch(Navigation& n) {
  n.glide = {};
  if (!n.walking) n.transition.reset();
  n.playback.reset();
  n.drift.reset();
}

void drag(Navigation& n, DragAction action, const glm::dvec2& pixels, const glm::dvec2& size) {
  switch (action) {
    case DragAction::orbit:
      n.view = orbit(n.view, pixels, size, n.up);
      break;
    case DragAction::look:
      n.view = look(n.view, pixels, size, n.up);
      break;
    case DragAction::pan:
      n.view = pan(n.view, pixels, size);
      break;
  }
}

void release(Navigation& n, DragAction action, const glm::dvec2& velocity) {
  n.glide = thrown(velocity);
  n.gliding = action;
}

void go_to(Navigation& n, const ViewState& view) {
  touch(n);
  const ViewState to = n.walking ? on_foot(view, *n.walking, n.units, n.up) : view;
  n.transition = Transition{.from = n.view, .to = to};
}

void start_walking(Navigation& n) {
  touch(n);
  n.walking = eye_height(n.home, n.units, n.up);
  go_to(n, stood_up(n.view, *n.walking, n.units, n.up));
}

void stop_walking(Navigation& n) {
  if (!n.walking) return;
  n.walking.reset();
  n.flying = {};
}

void keep_on_foot(Navigation& n) {
  if (n.walking && !n.transition) n.view = on_foot(n.view, *n.walking, n.units, n.up);
}

void play(Navigation& n, std::shared_ptr<const CameraPath> path, const glm::dvec2& size) {
  stop_walking(n);
  go_to(n, view_at(*path, 0, size));
  n.playback = Playback{.path = std::move(path)};
}

void drift(Navigation& n) {
  stop_walking(n);
  touch(n);
  n.drift = drift_from(n.view, n.units);
}

void reset(Navigation& n) {
  stop_walking(n);
  go_to(n, n.home);
}

void flip_up(Navigation& n) {
  stop_walking(n);
  touch(n);
  n.view = upside_down(n.view, n.up);
  n.home = upside_down(n.home, n.up);
  n.up = -n.up;
}

bool moving_by_itself(const Navigation& n) {
  return moving(n.glide) || n.transition || n.playback || n.drift;
}

bool moving(const Navigation& n) { return moving_by_itself(n) || is_flying(n.flying); }

bool advance(Navigation& n, double seconds, const glm::dvec2& size) {
  if (!moving(n)) return false;
  if (n.transition) {
    n.view = advance(*n.transition, seconds);
    if (finished(*n.transition)) n.transition.reset();
  } else if (n.playback) {
    play_on(n, seconds, size);
  } else if (n.drift) {
    n.view = advance(*n.drift, seconds, n.view, n.up);
  }
  if (moving(n.glide)) drag(n, n.gliding, advance(n.glide, seconds), size);
  if (is_flying(n.flying)) fly_on(n, seconds);
  keep_on_foot(n);
  return true;
}

}  // namespace fluxgs::camera
