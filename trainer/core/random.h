// Random numbers with the same values from every standard library: their distributions differ,
// their engines do not.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace fluxgs {

using Random = std::mt19937_64;

/// Uniform in [0, 1).
inline double uniform(Random& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// Standard normal (Box–Muller; one of the two values).
inline double normal(Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - uniform(random)));
  return radius * std::cos(2 * std::numbers::pi * uniform(random));
}

/// Fisher–Yates.
inline void shuffle(std::vector<std::uint32_t>& items, Random& random) {
  for (std::size_t i = items.size(); i > 1; --i)
    std::swap(items[i - 1],
              items[static_cast<std::size_t>(uniform(random) * static_cast<double>(i))]);
}

}  // namespace fluxgs
