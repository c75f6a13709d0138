// A view and what moves it: gestures now, and what goes on afterwards. The platforms translate
// fingers, mice and keys into these calls and draw while advance() says that something moves.
#pragma once

#include <optional>

#include "camera/drift.h"
#include "camera/fly.h"
#include "camera/inertia.h"
#include "camera/orbit.h"
#include "camera/pan_zoom.h"
#include "camera/path.h"
#include "camera/scene_fit.h"
#include "camera/transition.h"
#include "camera/view_state.h"
#include "camera/walk.h"

namespace fluxgs::camera {

/// Meaning of a dragged pointer.
enum class DragAction { orbit, look, pan };

struct Navigation {
  ViewState view;
  ViewState home;           ///< where reset() leads
  glm::dvec3 up{0, -1, 0};  ///< of unit length
  SceneUnits units;
  double speed_factor = 1;  ///< of flying
  FlyDirection flying;      ///< for as long as it is not zero
  /// The eye's height along up while people walk: then `flying` is walking.
  std::optional<double> walking;

  // What goes on by itself; a touch ends it.
  Glide glide;
  DragAction gliding = DragAction::orbit;
  std::optional<Transition> transition;
  // These two wait for a transition
  std::optional<Playback> playback;
  std::optional<Drift> drift;
};

/// Starts at a view, which is also home.
Navigation navigation_from(const ViewState& view, const glm::dvec3& up, const SceneUnits& units);

/// A finger or button went down: what went on by itself ends, but for the way to where a walk
/// begins.
void touch(Navigation& n);

/// A pointer that is down moved by `drag` pixels.
void drag(Navigation& n, DragAction action, const glm::dvec2& pixels, const glm::dvec2& size);

/// The pointer was lifted at a velocity in px/s: the drag goes on and dies away.
void release(Navigation& n, DragAction action, const glm::dvec2& velocity);

/// Goes smoothly to a view.
void go_to(Navigation& n, const ViewState& view);

/// Goes smoothly to the beginning of a path and plays it.
void play(Navigation& n, std::shared_ptr<const CameraPath> path, const glm::dvec2& size);

/// Goes smoothly to eye height and walks from there. What leads away from there ends a walk: a
/// path, auto-orbit, reset() and flip_up().
void start_walking(Navigation& n);
void stop_walking(Navigation& n);
/// While people walk: the view, put on foot again after it was moved otherwise.
void keep_on_foot(Navigation& n);

/// Turns slowly round the target from now on, from where the view is.
void drift(Navigation& n);

/// Smoothly to where it began.
void reset(Navigation& n);

/// Turns the scene upside down: the other direction is up, the eye keeps its height over the
/// scene's ground, and so does home.
void flip_up(Navigation& n);

/// True while something goes on that a touch would end.
bool moving_by_itself(const Navigation& n);
/// The same, or a key is held.
bool moving(const Navigation& n);

/// Lets time pass. Whether the view changed or will change.
bool advance(Navigation& n, double seconds, const glm::dvec2& size);

}  // namespace fluxgs::camera
