// Selection of splats where memory does not hold all of them.
#pragma once

#include <cstdint>
#include <vector>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::render {

/// The indices, ascending, of the `count` splats that add most (contribution.h); ties go by index.
std::vector<std::uint32_t> max_contributing(const SplatCloud& cloud, std::size_t count);

}  // namespace fluxgs::render
