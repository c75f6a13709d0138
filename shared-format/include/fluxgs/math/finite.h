// A check of many numbers at once.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

namespace fluxgs::math {

/// True if none is NaN or infinite. No branch for each, so that compilers vectorise the loop.
inline bool all_finite(std::span<const float> numbers) {
  constexpr std::int32_t kMagnitude = 0x7fffffff, kInfinity = 0x7f800000;
  std::int32_t largest = 0;
  for (const float x : numbers)
    largest = std::max(largest, std::bit_cast<std::int32_t>(x) & kMagnitude);
  return largest < kInfinity;
}

}  // namespace fluxgs::math
