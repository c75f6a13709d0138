// Rounding to integers that take few bits, not always the nearest one: rate–distortion
// optimised quantization (RDOQ) with a constant Lagrange multiplier.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fluxgs::codec {

/// Values over their step are smaller.
inline constexpr double kMaxInteger = 0x1p28;

/// Weights of splats are between these times the mean: what no image shows keeps a shape all the
/// same.
inline constexpr double kMinWeight = 0.05, kMaxWeight = 20;

/// std::lround() of |value| < 2³¹, without the call that compilers make of it.
inline std::int32_t nearest(double value) {
  const auto whole = static_cast<std::int32_t>(value);
  const double rest = value - whole;
  return whole + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
}

/// Terms of rate–distortion quantization: weight·(error)² + bits·rate_weight is made small, where
/// the error is in steps. 0 rounds to the nearest.
struct RateDistortion {
  double rate_weight = 0;               ///< the multiplier λ
  std::span<const float> weights = {};  ///< one for each value, 1 on the average; empty: all 1
};

/// Bits of integers that occur as often as they do in a list; a little more than in it for
/// those that do not occur.
class Prices {
 public:
  explicit Prices(std::span<const std::int32_t> integers);
  /// True if n is near enough to zero; beyond, a value's neighbours are about as rare.
  static bool knows(std::int32_t n) { return -kReach <= n && n <= kReach; }
  double operator()(std::int32_t n) const { return bits_[index(n)]; }

 private:
  static constexpr std::int32_t kReach = 2048;
  static std::size_t index(std::int32_t n) { return static_cast<std::size_t>(n + kReach); }
  std::vector<double> bits_;
};

/// Number of times that all values are chosen anew, because choices change how often values occur,
/// which changes choices.
inline constexpr int kQuantizationPasses = 2;

/// Integers for `values` as what is coded: themselves or, if `predicted`, their differences
/// from the prediction by those before. Each is the nearest or the one next to it towards the
/// cheaper zero, so that it is off by 1.5 at most; which of the two depends on how often the
/// values occur. |values| < kMaxInteger.
std::vector<std::int32_t> quantize_cheaply(std::span<const double> values, bool predicted,
                                           const RateDistortion& rate_distortion);

}  // namespace fluxgs::codec
