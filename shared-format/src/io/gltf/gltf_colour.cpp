#include "io/gltf/gltf_colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "cloud/activation.h"
#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs::io {
namespace {

/// A direction with its share of the sphere and the basis functions there.
struct Sample {
  double weight;  ///< all sum to 4π
  std::array<double, 16> basis;
};

// Gauss-Legendre along z (nodes and weights: Abramowitz & Stegun, table 25.4), equal steps around
// it: exact for polynomials of degree 11, enough for products of two harmonics of degree 3 and a
// curve that is not linear.
std::vector<Sample> sphere_samples() {
  constexpr std::array<std::array<double, 2>, 3> kNodes{{{0.2386191860831969, 0.4679139345726910},
                                                         {0.6612093864662645, 0.3607615730481386},
                                                         {0.9324695142031521, 0.1713244923791704}}};
  constexpr int kSteps = 12;
  std::vector<Sample> samples;
  for (const auto& [node, weight] : kNodes)
    for (const double z : {node, -node})
      for (int step = 0; step < kSteps; ++step) {
        const double angle = 2 * std::numbers::pi * step / kSteps, radius = std::sqrt(1 - z * z);
        Sample& sample = samples.emplace_back();
        sample.weight = weight * 2 * std::numbers::pi / kSteps;
        sample.basis[0] = math::kSh0;
        math::sh_basis(3, {radius * std::cos(angle), radius * std::sin(angle), z},
                       sample.basis.data() + 1);
      }
  return samples;
}

// IEC 61966-2-1, continued beyond 1.
double encoded(double linear) {
  const double l = std::max(linear, 0.0);
  return l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
}

}  // namespace

void encode_linear_colours(SplatCloud& cloud, std::size_t begin, std::size_t end) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const std::vector<Sample> samples = sphere_samples();
  for (std::size_t i = begin; i < end; ++i) {
    glm::vec3* bands = cloud.sh_rest.data() + i * rest;
    const bool constant = std::all_of(bands, bands + rest,
                                      [](const glm::vec3& band) { return band == glm::vec3(0); });
    for (int c = 0; c < 3; ++c) {
      if (constant) {
        cloud.sh_dc[i][c] = dc_of(encoded(colour_of(cloud.sh_dc[i][c])));
        continue;
      }
      std::array<double, 16> sums{};
      for (const Sample& sample : samples) {
        double colour = colour_of(cloud.sh_dc[i][c]);
        for (std::size_t k = 0; k < rest; ++k) colour += sample.basis[k + 1] * double{bands[k][c]};
        const double shown = encoded(colour) - 0.5;
        for (std::size_t k = 0; k <= rest; ++k) sums[k] += sample.weight * sample.basis[k] * shown;
      }
      cloud.sh_dc[i][c] = static_cast<float>(sums[0]);
      for (std::size_t k = 0; k < rest; ++k) bands[k][c] = static_cast<float>(sums[k + 1]);
    }
  }
}

}  // namespace fluxgs::io
