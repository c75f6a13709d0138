#include "codec/noise_shaping.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fluxgs::codec {
namespace {

/// Row j, column k ≤ j of a lower triangle that is stored row by row.
constexpr std::size_t entry(std::size_t j, std::size_t k) { return j * (j + 1) / 2 + k; }

}  // namespace

Expected<void> NoiseShapingQuantizer::run(const std::function<Expected<void>()>& pass) {
  const int passes = rate_weight_ > 0 ? 1 + kQuantizationPasses : 1;
  for (int k = 0; k < passes; ++k) {
    prices_.clear();
    if (k > 0)
      for (const auto& plane : planes_) prices_.emplace_back(plane);
    predictions_.assign(planes_.size(), {});
    if (auto ok = pass(); !ok) return ok;
  }
  return {};
}

Expected<void> NoiseShapingQuantizer::round(std::size_t i, const CoupledValues& shaped,
                                            std::size_t first, std::size_t stride,
                                            std::span<double> errors) {
  std::ranges::fill(errors, 0.0);
  for (std::size_t k = shaped.x.size(); k-- > shaped.kept;) {
    const double z = (shaped.x[k] + compensation(shaped, k, errors)) / shaped.step;
    if (!(std::abs(z) < kMaxInteger))
      return fail("", "",
                  fmt::format("splat {}: a value over the step of {:g} is not within ±2²⁸", i,
                              shaped.step));
    const double diagonal = shaped.factor[entry(k, k)];
    const std::size_t plane = first + (k - shaped.kept) * stride;
    const std::int32_t expected = predicted_[plane] != 0 ? predictions_[plane].next() : 0;
    planes_[plane][i] = choose(z - expected, shaped.weight * diagonal * diagonal, plane);
    const std::int32_t number = expected + planes_[plane][i];
    predictions_[plane].add(number);
    errors[k] = shaped.x[k] - number * shaped.step;
  }
  return {};
}

double NoiseShapingQuantizer::compensation(const CoupledValues& shaped, std::size_t k,
                                           std::span<const double> errors) {
  double sum = 0;
  for (std::size_t j = k + 1; j < shaped.x.size(); ++j)
    sum += double{shaped.factor[entry(j, k)]} * errors[j];
  return sum / double{shaped.factor[entry(k, k)]};
}

/// The best value from the nearest to zero: where errors are made up for, it may be far from both.
std::int32_t NoiseShapingQuantizer::choose(double z, double weight, std::size_t plane) const {
  const std::int32_t near = nearest(z);
  if (near == 0 || prices_.empty() || !Prices::knows(near)) return near;
  const auto error = [&](std::int32_t n) { return weight * (z - n) * (z - n); };
  const auto bits = [&](std::int32_t n) { return rate_weight_ * prices_[plane](n); };
  std::int32_t best = near;
  double least = error(near) + bits(near);
  for (std::int32_t n = near; n != 0 && error(n) < least;) {
    n += near > 0 ? -1 : 1;
    if (const double cost = error(n) + bits(n); cost < least) least = cost, best = n;
  }
  return best;
}

}  // namespace fluxgs::codec
