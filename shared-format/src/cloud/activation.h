// Between what a SplatCloud stores (logit, logarithm, coefficient of the constant harmonic) and
// what most formats store (opacity, scale, colour). So that the ends of the range stay finite,
// opacity ≤ 0 becomes logit ≈ −87.3 (2⁻¹²⁶), opacity ≥ 1 becomes ≈ 17.3 (1 − 2⁻²⁵, half-way to the
// float below one) and scale 0 becomes logarithm ≈ −87.3. NaN stays NaN and a negative scale
// becomes NaN, so that such splats are dropped and counted.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "fluxgs/math/logistic.h"
#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs::io {

inline constexpr double kMinValue = std::numeric_limits<float>::min();
inline constexpr double kMaxOpacity = 1 - 0x1p-25;

inline float logit_of(double opacity) {
  const double o = opacity <= 0 ? kMinValue : opacity >= 1 ? kMaxOpacity : opacity;
  return static_cast<float>(std::log(o) - std::log1p(-o));
}
inline float opacity_of(float logit) { return static_cast<float>(sigmoid(double{logit})); }

inline double log_scale(double scale) { return std::log(scale == 0 ? kMinValue : scale); }

/// Limited to the range of float.
inline float linear_scale(float log_scale) {
  constexpr double kMax = std::numeric_limits<float>::max();
  return static_cast<float>(std::min(std::exp(double{log_scale}), kMax));
}

/// Display-referred colour, 0…1 where it can be shown (3DGS, Kerbl et al. 2023).
inline double colour_of(float dc) { return math::kSh0 * double{dc} + 0.5; }
inline float dc_of(double colour) { return static_cast<float>((colour - 0.5) / math::kSh0); }

/// The nearest of 256 levels of 0…1; values beyond are limited to it.
inline std::uint8_t byte_of(double unit) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(unit, 0.0, 1.0)));
}

/// The logits of opacities stored in 8 bits.
inline std::array<float, 256> logits_of_bytes() {
  std::array<float, 256> table;
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = logit_of(static_cast<double>(i) / 255);
  return table;
}

}  // namespace fluxgs::io
