// Quantization of values that belong together where errors of one can be made up for by the others:
// where errors e of a splat's values cost eᵀ·H·e = |Lᵀ·e|². Values are quantized one after the
// other, the last first. Row k of Lᵀ has nothing before k: the best value k for given errors of
// those above it is x_k + Σ_{j>k} L_jk·e_j/L_kk, and being off from that by δ costs (L_kk·δ)²,
// whatever comes after. This is noise shaping, or the successive cancellation of Babai's nearest
// plane (1986), with which weights of neural networks are quantized too (Frantar et al. 2023,
// "GPTQ"). The leading part of L is the L of the leading values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "codec/prediction.h"
#include "codec/quantization.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Values of one splat that are quantized together.
struct CoupledValues {
  std::span<const double> x;      ///< n of them
  std::span<const float> factor;  ///< the lower triangle of L, row by row
  double step = 1;
  double weight = 1;     ///< of the squared error in steps; a bit costs rate_weight
  std::size_t kept = 0;  ///< the first so many are not quantized
};

class NoiseShapingQuantizer {
 public:
  static constexpr std::size_t kMax = 16;  ///< values in a CoupledValues

  /// Integers of each plane are priced together; where `predicted` is 1, by what they differ
  /// from the prediction (prediction.h) of the splats before.
  NoiseShapingQuantizer(std::vector<std::uint8_t> predicted, std::size_t splats, double rate_weight)
      : rate_weight_(rate_weight),
        predicted_(std::move(predicted)),
        planes_(predicted_.size(), std::vector<std::int32_t>(splats)) {}

  /// Calls `pass`, which is to round all splats in their order, first to the nearest and then again
  /// with the prices of what came out.
  Expected<void> run(const std::function<Expected<void>()>& pass);

  /// Rounds values n−1…kept of splat i into planes first, first + stride…; an error where a value
  /// is beyond ±2²⁸ steps. `errors` (n), what they lost, is 0 for those that are kept.
  Expected<void> round(std::size_t i, const CoupledValues& shaped, std::size_t first,
                       std::size_t stride, std::span<double> errors);

  /// Shift of value k that makes up for the errors of the values behind it.
  static double compensation(const CoupledValues& shaped, std::size_t k,
                             std::span<const double> errors);

  /// The values, or their differences from the prediction.
  std::vector<std::vector<std::int32_t>> planes() && { return std::move(planes_); }

 private:
  std::int32_t choose(double z, double weight, std::size_t plane) const;

  double rate_weight_;
  std::vector<std::uint8_t> predicted_;
  std::vector<Prediction> predictions_;  ///< by plane
  std::vector<Prices> prices_;           ///< by plane; empty: the nearest is taken
  std::vector<std::vector<std::int32_t>> planes_;
};

}  // namespace fluxgs::codec
