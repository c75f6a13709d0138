#include "trainer/appearance/energy_moments.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs {
namespace {

constexpr std::size_t kBlock = 8;     // splats at a time: what SSE registers hold of the sums
constexpr std::size_t kPiece = 1024;  // splats per piece of parallel work
constexpr std::size_t kBasis = 15, kMoments = 4;

using Block = std::array<float, kBlock>;

/// A direction of the rule: the basis functions there, and its weight times (1, x, y, z).
struct Sample {
  std::array<float, kBasis> basis;
  std::array<float, kMoments> moments;
};

std::vector<Sample> samples_of(const SphereRule& rule) {
  std::vector<Sample> samples(rule.directions.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const glm::dvec3& d = rule.directions[k];
    const double w = rule.weights[k];
    std::array<double, kBasis> basis{};
    math::sh_basis(3, math::Vec3<double>{d.x, d.y, d.z}, basis.data());
    std::ranges::transform(basis, samples[k].basis.begin(),
                           [](double b) { return static_cast<float>(b); });
    samples[k].moments = {static_cast<float>(w), static_cast<float>(w * d.x),
                          static_cast<float>(w * d.y), static_cast<float>(w * d.z)};
  }
  return samples;
}

/// The coefficients beyond the constant one that make up the residual: [first, end).
struct Bands {
  int first, end;
};

Bands bands_of(Residual residual, int degree) {
  const int below = residual == Residual::from_0 ? 0 : residual == Residual::from_1 ? 1 : 2;
  return {sh_rest_count(below), sh_rest_count(degree)};
}

/// One channel of a block of splats; sums and residual stay in registers.
std::array<Block, kMoments> sum_moments(const std::vector<Sample>& samples,
                                        const std::array<Block, kBasis>& coefficients,
                                        Bands bands) {
  std::array<Block, kMoments> sums{};
  for (const Sample& sample : samples) {
    Block f{};
    for (int k = bands.first; k < bands.end; ++k) {
      const auto at = static_cast<std::size_t>(k);
      for (std::size_t lane = 0; lane < kBlock; ++lane)
        f[lane] += sample.basis[at] * coefficients[at][lane];
    }
    for (std::size_t lane = 0; lane < kBlock; ++lane) f[lane] = f[lane] > 0 ? f[lane] : 0;
    for (std::size_t m = 0; m < kMoments; ++m)
      for (std::size_t lane = 0; lane < kBlock; ++lane)
        sums[m][lane] += sample.moments[m] * f[lane];
  }
  return sums;
}

void block_moments(const PlanarFloats& parameters, std::size_t i,
                   const std::vector<Sample>& samples, Bands bands, PlanarFloats& moments) {
  for (int c = 0; c < 3; ++c) {
    std::array<Block, kBasis> coefficients;
    Block unsound{};  // NaN where a coefficient is not finite
    for (int k = bands.first; k < bands.end; ++k) {
      const float* from = parameters.row(row::sh_rest + 3 * k + c) + i;
      std::copy_n(from, kBlock, coefficients[static_cast<std::size_t>(k)].begin());
      for (std::size_t lane = 0; lane < kBlock; ++lane) unsound[lane] += from[lane] - from[lane];
    }
    const std::array<Block, kMoments> sums = sum_moments(samples, coefficients, bands);
    for (std::size_t m = 0; m < kMoments; ++m)
      for (std::size_t lane = 0; lane < kBlock; ++lane) {
        const float value = sums[m][lane] + unsound[lane];
        moments.row(static_cast<int>(3 * m) + c)[i + lane] = std::isfinite(value) ? value : 0;
      }
  }
}

}  // namespace

PlanarFloats energy_moments(const PlanarFloats& parameters, Residual residual,
                            const SphereRule& rule, const Threads& threads) {
  static_assert(PlanarFloats::kPadding % kBlock == 0 && kPiece % kBlock == 0);
  const std::vector<Sample> samples = samples_of(rule);
  const Bands bands = bands_of(residual, sh_degree_of(parameters));
  PlanarFloats moments(3 * static_cast<int>(kMoments), parameters.size());
  threads.for_pieces(parameters.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; i += kBlock)
      block_moments(parameters, i, samples, bands, moments);
  });
  return moments;
}

}  // namespace fluxgs
