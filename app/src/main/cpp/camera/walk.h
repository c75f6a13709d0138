// Walking: the eye keeps its height, and does not leave the scene.
#pragma once

#include "camera/fly.h"
#include "camera/scene_fit.h"
#include "camera/view_state.h"

namespace fluxgs::camera {

/// The height of the eye along `up` (a unit vector): that of the view which the scene is shown with
/// first, if that is from within, as of one who took photos there; otherwise the scene's middle.
double eye_height(const ViewState& home, const SceneUnits& units, const glm::dvec3& up);

/// The view, moved and not turned, with the eye at this height and in the scene: no farther from
/// the middle than its radius, level.
ViewState on_foot(const ViewState& view, double height, const SceneUnits& units,
                  const glm::dvec3& up);

/// The view to begin a walk with: on foot, upright, and level where it looked far up or down.
ViewState stood_up(const ViewState& view, double height, const SceneUnits& units,
                   const glm::dvec3& up);

/// The view after walking for a time, on foot. Of the direction `up` counts for nothing, and
/// slanted ways are not faster; `speed` in scene units per second.
ViewState walk(const ViewState& view, const FlyDirection& direction, double speed, double seconds,
               double height, const SceneUnits& units, const glm::dvec3& up);

}  // namespace fluxgs::camera
