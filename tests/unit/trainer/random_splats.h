// Splats and views for the tests of this folder.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

#include "fluxgs/math/spherical_harmonics.h"
#include "trainer/compress/sh_fit.h"
#include "trainer/core/random.h"

namespace fluxgs::test {

/// Splats at the origin whose SH coefficients beyond the constant one are standard normal.
inline PlanarFloats random_sh(std::size_t count, std::uint64_t seed, int degree = 3) {
  Random random(seed);
  PlanarFloats p(row::count(degree), count);
  for (int r = row::sh_dc; r < p.rows(); ++r)
    for (std::size_t i = 0; i < count; ++i) p.row(r)[i] = static_cast<float>(normal(random));
  return p;
}

/// Uniform in the cone of a half-angle around +z.
inline glm::dvec3 in_cone(double half_angle, Random& random) {
  const double z = 1 - uniform(random) * (1 - std::cos(half_angle));
  const double phi = 2 * std::numbers::pi * uniform(random), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

inline double degrees(double x) { return x * std::numbers::pi / 180; }

/// Cameras that see every splat (at the origin) along `directions`, with weights in (0.5, 1.5).
inline ViewWeights views_along(const std::vector<glm::dvec3>& directions, std::size_t splats,
                               Random& random) {
  ViewWeights views{.weights = PlanarFloats(static_cast<int>(directions.size()), splats),
                    .pixels = 1000.0 * static_cast<double>(directions.size())};
  for (std::size_t v = 0; v < directions.size(); ++v) {
    views.centers.push_back(-4.0 * directions[v]);
    for (std::size_t i = 0; i < splats; ++i)
      views.weights.row(static_cast<int>(v))[i] = static_cast<float>(0.5 + uniform(random));
  }
  return views;
}

/// The colour of splat i (without the 0.5) in a direction, in float64.
inline glm::dvec3 color_at(const PlanarFloats& p, std::size_t i, const glm::dvec3& d) {
  double basis[kShCount] = {math::kSh0};
  math::sh_basis(3, math::Vec3<double>{d.x, d.y, d.z}, basis + 1);
  glm::dvec3 sum(0);
  for (int r = row::sh_dc; r < p.rows(); ++r)
    sum[(r - row::sh_dc) % 3] += basis[(r - row::sh_dc) / 3] * double{p.row(r)[i]};
  return sum;
}

/// Σ w·|a − b|² over the views of splat i: the definition.
inline double square_loss(const ViewWeights& views, const PlanarFloats& a, const PlanarFloats& b,
                          std::size_t i) {
  const glm::dvec3 position(a.row(0)[i], a.row(1)[i], a.row(2)[i]);
  double sum = 0;
  for (int v = 0; v < views.weights.rows(); ++v) {
    const glm::dvec3 d = glm::normalize(position - views.centers[static_cast<std::size_t>(v)]);
    const glm::dvec3 difference = color_at(a, i, d) - color_at(b, i, d);
    sum += double{views.weights.row(v)[i]} * glm::dot(difference, difference);
  }
  return sum;
}

}  // namespace fluxgs::test
