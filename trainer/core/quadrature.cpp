#include "trainer/core/quadrature.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "trainer/core/lebedev.h"
#include "trainer/core/random.h"

namespace fluxgs {
namespace {

using std::numbers::pi;

glm::dvec3 direction(double cos_theta, double phi) {
  const double sin_theta = std::sqrt(std::max(0.0, (1 - cos_theta) * (1 + cos_theta)));
  return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), cos_theta};
}

/// Bands of equal area, each turned against the one before by the golden angle.
std::vector<glm::dvec3> fibonacci(int samples) {
  const double golden_angle = pi * (3 - std::sqrt(5.0));
  std::vector<glm::dvec3> directions;
  for (int k = 0; k < samples; ++k)
    directions.push_back(direction(1 - (2.0 * k + 1) / samples, golden_angle * k));
  return directions;
}

/// φ ~ U(0, 2π), θ = arccos(1 − 2ξ), ξ ~ U(0, 1).
std::vector<glm::dvec3> monte_carlo(int samples, std::uint64_t seed) {
  Random random(seed);
  std::vector<glm::dvec3> directions;
  for (int k = 0; k < samples; ++k) {
    const double phi = 2 * pi * uniform(random);
    directions.push_back(direction(1 - 2 * uniform(random), phi));
  }
  return directions;
}

}  // namespace

Expected<SphereRule> sphere_rule(Quadrature quadrature, int samples, std::uint64_t seed) {
  const bool lebedev = quadrature == Quadrature::lebedev;
  const int most = lebedev ? kMaxLebedevSamples : kMaxSphereSamples;
  if (samples < 1 || samples > most)
    return fail("", "--samples",
                fmt::format("{} is out of range, expected 1 to {} for --quadrature {}", samples,
                            most, name_of(quadrature)));
  if (lebedev) return lebedev_rule(samples);
  SphereRule rule;
  rule.directions =
      quadrature == Quadrature::fibonacci ? fibonacci(samples) : monte_carlo(samples, seed);
  rule.weights.assign(rule.directions.size(), 1.0 / samples);
  return rule;
}

}  // namespace fluxgs
