// PSNR: mean square errors of colours of 0…1 in decibels.
#pragma once

#include <cmath>
#include <limits>

namespace fluxgs {

/// 10·log₁₀(1/mse); infinity for 0.
inline double psnr_of_mse(double mse) {
  return mse == 0 ? std::numeric_limits<double>::infinity() : -10 * std::log10(mse);
}

/// Largest PSNR of a render against an 8-bit image: the error of rounding to 8 bits, 1/(12·255²).
/// Without such a limit one exact render, of an all black image for example, would make means
/// infinite.
inline const double kMaxPsnr = psnr_of_mse(1 / (12 * 255.0 * 255.0));

inline double mse_of_psnr(double psnr) { return std::pow(10, -psnr / 10); }

/// The mean square error that costs `decibels` (≥ 0) of PSNR when it is added to `mse`.
inline double added_mse(double mse, double decibels) {
  return mse * (std::pow(10, decibels / 10) - 1);
}

}  // namespace fluxgs
