// Symmetric and lower triangular matrices of 3×3 as lists hold them: the lower triangle, row by
// row.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "fluxgs/io/sensitivity_weights.h"

namespace fluxgs::codec {

using Symmetric3 = std::array<float, kSymmetric3>;

inline Eigen::Matrix3d symmetric(std::span<const float, kSymmetric3> t) {
  Eigen::Matrix3d h;
  h << double{t[0]}, double{t[1]}, double{t[3]},  //
      double{t[1]}, double{t[2]}, double{t[4]},   //
      double{t[3]}, double{t[4]}, double{t[5]};
  return h;
}

inline Symmetric3 lower_triangle(const Eigen::Matrix3d& m) {
  const Eigen::Matrix3f f = m.cast<float>();
  return {f(0, 0), f(1, 0), f(1, 1), f(2, 0), f(2, 1), f(2, 2)};
}

/// The matrix of splat i.
inline std::span<const float, kSymmetric3> symmetric3_of(std::span<const float> matrices,
                                                         std::size_t i) {
  return matrices.subspan(kSymmetric3 * i).first<kSymmetric3>();
}

}  // namespace fluxgs::codec
