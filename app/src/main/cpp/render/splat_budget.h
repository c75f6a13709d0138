// Selection of splats where memory does not hold all of them.
#pragma once

#include <cstdint>
#include <vector>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::render {

/// Estimated contribution of splat i to images, from no place in particular: its opacity times the
/// mean area of its shadows along its own three axes, in square scene units. 0 where an attribute
/// is not a number.
double contribution(const SplatCloud& cloud, std::size_t i);

/// The indices, ascending, of the `count` splats that add most; ties go by index.
std::vector<std::uint32_t> max_contributing(const SplatCloud& cloud, std::size_t count);

}  // namespace fluxgs::render
