// Auto-orbit: a slow turn of the view around its target that goes on by itself.
#pragma once

#include "camera/scene_fit.h"
#include "camera/view_state.h"

namespace fluxgs::camera {

/// Starts at rest and takes a while to its full speed. All the way round where the target is about
/// the scene's middle or the eye outside of the scene; elsewhere, as in a room, the way round may
/// lead through walls, and the view swings to and fro.
struct Drift {
  double elapsed = 0;   ///< seconds
  double farthest = 0;  ///< radians to either side; 0: all the way round
};

/// Radians a second, at full speed: a minute for all the way round.
inline constexpr double kDriftSpeed = 0.1;

Drift drift_from(const ViewState& view, const SceneUnits& units);

/// Lets time pass: the view, turned about `up` (a unit vector) through its target. The distance,
/// the elevation and the roll stay what they are.
ViewState advance(Drift& drift, double seconds, const ViewState& view, const glm::dvec3& up);

}  // namespace fluxgs::camera
