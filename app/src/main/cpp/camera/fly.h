// Flying: the eye moves through the scene and the target goes with it. look() in orbit.h turns.
#pragma once

#include "camera/view_state.h"

namespace fluxgs::camera {

/// Direction of flight, each −1…1: to the camera's right, along the scene's up axis, along the
/// view.
struct FlyDirection {
  double right = 0, up = 0, forward = 0;
};

/// The view after flying for a time at a speed in scene units per second. Slanted ways are not
/// faster: a direction longer than 1 counts as of length 1. `up` is a unit vector.
ViewState fly(const ViewState& view, const FlyDirection& direction, double speed, double seconds,
              const glm::dvec3& up);

}  // namespace fluxgs::camera
