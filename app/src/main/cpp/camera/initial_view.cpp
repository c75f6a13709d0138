#include "camera/initial_view.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "camera/focus.h"
#include "camera/up_axis.h"

namespace fluxgs::camera {
namespace {

/// Field of view of the shorter side of an image of this size that shows all of the photo, but no
/// more than kWidest across its longer side: what lies beside a photo was not trained.
double fitting_fov(const InitialView& initial, const glm::dvec2& size) {
  constexpr double kWidest = 1.75;  // 100 degrees
  const double slope = std::tan(0.5 * initial.fov_y);
  if (initial.image_width <= 0 || initial.image_height <= 0) return initial.fov_y;
  const glm::dvec2 photo(initial.image_width, initial.image_height);
  const glm::dvec2 wanted = slope * photo / std::min(photo.x, photo.y);  // slopes to its borders
  const glm::dvec2 shape = size / std::max(std::min(size.x, size.y), 1.0);
  const double fits = std::max(wanted.x / shape.x, wanted.y / shape.y);
  const double widest = std::tan(0.5 * kWidest) / std::max(shape.x, shape.y);
  return 2 * std::atan(std::max(slope, std::min(fits, widest)));
}

ViewState view_from(const InitialView& initial, const SplatCloud& cloud, const SceneBounds& bounds,
                    const SceneUnits& units, const glm::dvec2& size) {
  ViewState view{
      .target = {}, .orientation = initial.orientation, .fov = fitting_fov(initial, size)};
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
