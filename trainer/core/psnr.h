// Mean square errors of colours of 0…1, and the decibels that they are said in (PSNR).
#pragma once

#include <cmath>
#include <limits>

namespace fluxgs {

/// 10·log₁₀(1/mse); infinity for 0.
inline double psnr_of_mse(double mse) {
  return mse == 0 ? std::numeric_limits<double>::infinity() : -10 * std::log10(mse);
}

/// An image that is nearer to its image, such as an all black one, is as good as the image: this
/// is the error of rounding to its 8 bits, 1/(12·255²). Without such a limit one would make means
/// infinite.
inline const double kAsGoodAsTheView = psnr_of_mse(1 / (12 * 255.0 * 255.0));

inline double mse_of_psnr(double psnr) { return std::pow(10, -psnr / 10); }

/// The mean square error that costs `decibels` (≥ 0) of PSNR when it is added to `mse`.
inline double added_mse(double mse, double decibels) {
  return mse * (std::pow(10, decibels / 10) - 1);
}

}  // namespace fluxgs
