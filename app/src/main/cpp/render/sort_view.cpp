#include "render/sort_view.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace fluxgs::render {

sort::SortView sort_view(const Camera& camera, double near_plane, const SceneConstants& scene,
                         int key_bits) {
  const glm::dvec3 centre = camera.center() - scene.origin, forward = camera.forward();
  return {
      .centre = centre,
      .forward = forward,
      .near_plane = near_plane,
      .keys = sort::depth_keys(centre, forward, near_plane, scene.lowest, scene.highest, key_bits)};
}

double motion_between(const sort::SortView& from, const sort::SortView& to) {
  // The scene's middle is the origin of SortView::centre
  const double moved = glm::length(to.centre - from.centre);
  const double away = glm::length(from.centre);
  // Exact for small angles, unlike acos of the scalar product
  const double angle = std::atan2(glm::length(glm::cross(from.forward, to.forward)),
                                  glm::dot(from.forward, to.forward));
  if (moved > 0 && away == 0) return std::numeric_limits<double>::infinity();
  return angle + (moved > 0 ? moved / away : 0.0);
}

}  // namespace fluxgs::render
