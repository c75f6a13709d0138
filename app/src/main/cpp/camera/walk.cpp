#include "camera/walk.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "camera/orbit.h"

namespace fluxgs::camera {

double eye_height(const ViewState& home, const SceneUnits& units, const glm::dvec3& up) {
  const bool within = glm::distance(eye(home), units.center) < units.radius;
  return glm::dot(within ? eye(home) : units.center, up);
}

ViewState on_foot(const ViewState& view, double height, const SceneUnits& units,
                  const glm::dvec3& up) {
  const glm::dvec3 from = eye(view);
  glm::dvec3 arm = from - units.center;
  arm -= up * glm::dot(arm, up);
  const double length = glm::length(arm);
  if (length > units.radius) arm *= units.radius / length;
  const glm::dvec3 to = units.center + arm + up * (height - glm::dot(units.center, up));
  ViewState result = view;
  result.target += to - from;
  return result;
}

ViewState stood_up(const ViewState& view, double height, const SceneUnits& units,
                   const glm::dvec3& up) {
  constexpr double kSteepest = 0.35;  // radians
  ViewState result = upright(view, up);
  if (std::abs(elevation(result, up)) > kSteepest) {
    const glm::dvec3 from = eye(view);
    result = view_between(from, from + view.distance * level_direction(result, up), up, view.fov);
  }
  return on_foot(result, height, units, up);
}

ViewState walk(const ViewState& view, const FlyDirection& direction, double speed, double seconds,
               double height, const SceneUnits& units, const glm::dvec3& up) {
  const glm::dvec3 ahead = level_direction(view, up);
  const glm::dvec3 way = direction.right * glm::cross(ahead, up) + direction.forward * ahead;
  ViewState result = view;
  result.target += way * (speed * seconds / std::max(glm::length(way), 1.0));
  return on_foot(result, height, units, up);
}

}  // namespace fluxgs::camera
