// Centre and size of most of a scene, without the few splats far from it; for formats whose steps
// grow with the extent of the scene.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

struct SceneCore {
  glm::dvec3 center{0};  ///< median of each coordinate
  double radius = 0;     ///< median distance from it
};

/// The core of one or more positions.
SceneCore scene_core(const std::vector<glm::vec3>& positions);

/// The median over the splats of the logarithm of their size, the geometric mean of the standard
/// deviations; of two splats the smaller one's, since the other may be out of all proportion.
/// Splats whose size is not finite do not count; 0 where none is left.
double median_log_size(const SplatCloud& cloud);

/// Factor, 0…1, by which a position must come nearer to the core's centre, which lies within ±limit
/// of the origin on each axis, so that it does, too.
double factor_within(const glm::vec3& position, const SceneCore& core, double limit);

/// Moves splat i nearer to the core's centre by this factor and makes it as much smaller: seen from
/// there it looks the same.
void pull_in(SplatCloud& cloud, std::size_t i, const SceneCore& core, double factor);

}  // namespace fluxgs::io
