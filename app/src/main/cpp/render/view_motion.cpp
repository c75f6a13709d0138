#include "render/view_motion.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace fluxgs::render {

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
