#include "camera/initial_view.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "camera/focus.h"
#include "camera/up_axis.h"

namespace fluxgs::camera {
namespace {

ViewState view_from(const InitialView& initial, const SplatCloud& cloud, const SceneBounds& bounds,
                    const SceneUnits& units, const glm::dvec2& size) {
  ViewState view{.target = {}, .orientation = initial.orientation, .fov = initial.fov_y};
  const glm::dvec3 ahead = forward(view);
  // As far as the middle of the scene, unless something else is seen
  view.distance = glm::dot(bounds.center - initial.position, ahead);
  view.distance = std::clamp(view.distance, units.distances.nearest, units.distances.farthest);
  view.target = initial.position + view.distance * ahead;
  const auto seen = visible_point(cloud, view, 0.5 * size, size, units.near_plane);
  if (!seen) return view;
  view.distance = std::clamp(glm::dot(*seen - initial.position, ahead), units.distances.nearest,
                             units.distances.farthest);
  view.target = initial.position + view.distance * ahead;
  return view;
}

}  // namespace

Navigation initial_navigation(const SplatCloud& cloud, const std::optional<InitialView>& initial,
                              const glm::dvec2& size) {
  const SceneBounds bounds = robust_bounds(cloud);
  const SceneUnits units = units_of(bounds);
  if (initial)
    return navigation_from(view_from(*initial, cloud, bounds, units, size), initial->up, units);
  const glm::dvec3 up = up_of_cloud(cloud).direction;
  return navigation_from(fitting_view(bounds, up, kDefaultFieldOfView), up, units);
}

}  // namespace fluxgs::camera
