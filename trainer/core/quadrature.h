// Directions all over the sphere, for means of functions of the direction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/error.h"

namespace fluxgs {

/// Approximation of means over the sphere.
enum class Quadrature { fibonacci, lebedev, mc };
inline constexpr std::array<std::string_view, 3> kQuadratureNames = {"fibonacci", "lebedev", "mc"};

inline constexpr std::string_view name_of(Quadrature q) {
  return kQuadratureNames[static_cast<std::size_t>(q)];
}

/// Unit directions and weights that add up to 1: Σ wₖ·f(dₖ) stands for (1/4π)∫f dω.
struct SphereRule {
  std::vector<glm::dvec3> directions = {};
  std::vector<double> weights = {};  ///< positive, one for each direction
};

inline constexpr int kMaxSphereSamples = 1 << 20;
inline constexpr int kMaxLebedevSamples = 302;

/// A rule of `samples` (1…kMaxSphereSamples) directions.
/// fibonacci: a spiral of equal areas, all weights equal (Swinbank & Purser 2006, "Fibonacci
/// grids"). lebedev: exact for polynomials (Lebedev 1976); the smallest of 6, 14, 26, 38, 50, 86,
/// 110, 146,
///   170, 194, 302 directions that is not below `samples` (at most kMaxLebedevSamples).
/// mc: the paper's "Uniform Spherical Sampling", by `seed`, which the others do not look at.
/// Errors name --samples.
Expected<SphereRule> sphere_rule(Quadrature quadrature, int samples, std::uint64_t seed);

}  // namespace fluxgs
