// The middle of positions by medians, which a few stray ones do not move.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace fluxgs {

struct Middle {
  glm::dvec3 centre{0.0};  ///< median of each coordinate
  double radius = 0;       ///< median distance from it
};

/// The middle of one or more positions.
Middle middle_of(const std::vector<glm::dvec3>& positions);

}  // namespace fluxgs
