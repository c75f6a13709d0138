// Estimated contribution of a splat to images.
#pragma once

#include <cstddef>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// Contribution of splat i to images, from no place in particular: its opacity times the mean area
/// of its shadows along its own three axes, in square scene units. 0 where an attribute is not a
/// number.
double contribution(const SplatCloud& cloud, std::size_t i);

}  // namespace fluxgs
