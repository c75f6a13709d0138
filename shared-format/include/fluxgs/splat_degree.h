// The SH degree that single splats of a cloud need.
#pragma once

#include <array>
#include <cstddef>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// The degree that splat i needs, at most the cloud's: the highest of which it has a coefficient
/// that is not exactly zero (NaN is not zero). In a cloud of adaptive degree the bands that a splat
/// does without are zeros; compact files and the renderer leave them out.
int sh_degree_of(const SplatCloud& cloud, std::size_t i);

/// Number of splats that need each degree, 0…3.
using DegreeCounts = std::array<std::size_t, 4>;
/// Counts the splats of each degree, of any kind of cloud that has size() and sh_degree_of().
template <class Cloud = SplatCloud>
DegreeCounts count_degrees(const Cloud& cloud) {
  DegreeCounts counts{};
  for (std::size_t i = 0; i < cloud.size(); ++i)
    ++counts[static_cast<std::size_t>(sh_degree_of(cloud, i))];
  return counts;
}

}  // namespace fluxgs
