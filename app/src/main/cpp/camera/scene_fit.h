// Robust bounds of a scene, the view that shows all of it, and the units of moving through it.
#pragma once

#include <utility>
#include <vector>

#include "camera/view_state.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::camera {

/// Value and weight ≥ 0.
using Weighted = std::pair<double, double>;

/// The least value with at least this part (0…1) of the weight at or below it; of equal weights if
/// all are 0. Reorders `values`, which is not empty.
double quantile(std::vector<Weighted>& values, double part);

/// Sphere that holds most of the visible splats: a few far floaters do not matter, nor splats that
/// are not finite. Of clouds beyond a hundred thousand splats an even sample is looked at.
struct SceneBounds {
  glm::dvec3 low{-1.0}, high{1.0};  ///< per axis: 2 % and 98 % of the weight are below
  glm::dvec3 center{0.0};           ///< the middle of the box
  double radius = 1;                ///< around the centre: 90 % of the weight; > 0
};

enum class SplatWeight {
  opacity,  ///< a haze of low-opacity splats does not matter
  equal,
};

/// An empty cloud gets the sphere initialised above. A scene smaller than its splats is as large as
/// they are.
SceneBounds robust_bounds(const SplatCloud& cloud, SplatWeight weight = SplatWeight::opacity);

/// Units of movement through a scene, and where it lies.
struct SceneUnits {
  double near_plane = 0.01;  ///< for RenderOptions, scene units
  double speed = 0.5;        ///< of flying, scene units per second
  DistanceLimits distances;
  glm::dvec3 center{0.0};  ///< of SceneBounds, and its radius
  double radius = 1;
};

SceneUnits units_of(const SceneBounds& bounds);

/// The horizontal direction, as seen from the scene, from which it is looked at first: the −z axis
/// made level, or −x where `up` (a unit vector) is about z.
glm::dvec3 level_front(const glm::dvec3& up);

/// Distance at which a sphere fills the image's shorter side, of which `fov` is, but for a margin
/// of 15 %.
double fitting_distance(double radius, double fov);

/// The part of the distance that the initial view stands above the scene's middle.
inline constexpr double kInitialHeight = 0.3;

/// All of the scene, from its front and slightly above.
ViewState fitting_view(const SceneBounds& bounds, const glm::dvec3& up, double fov);

}  // namespace fluxgs::camera
