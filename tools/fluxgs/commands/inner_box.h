// The box around most of a scene.
#pragma once

#include <glm/vec3.hpp>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::cli {

struct Box {
  glm::dvec3 min{0}, max{0};  ///< scene units
};

/// The box between the 1st and the 99th percentile of each axis, which a few splats far away do not
/// stretch. Zeros for a scene without splats.
Box inner_box(const SplatCloud& cloud);

}  // namespace fluxgs::cli
