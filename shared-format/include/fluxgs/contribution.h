// Estimated contribution of a splat to images, and choice of those that come first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// Contribution of splat i to images, from no place in particular: its opacity times the mean area
/// of its shadows along its own three axes, in square scene units. 0 where an attribute is not a
/// number.
double contribution(const SplatCloud& cloud, std::size_t i);

/// The indices, ascending, of the `count` of 0…size − 1 that come first by before(a, b), which must
/// not hold two of them for equal; all where there are no more.
template <class Before>
std::vector<std::uint32_t> first_indices(std::size_t size, std::size_t count, Before before) {
  std::vector<std::uint32_t> indices(size);
  std::iota(indices.begin(), indices.end(), 0U);
  if (count >= size) return indices;
  std::ranges::nth_element(indices, indices.begin() + static_cast<std::ptrdiff_t>(count), before);
  indices.resize(count);
  std::ranges::sort(indices);
  return indices;
}

}  // namespace fluxgs
