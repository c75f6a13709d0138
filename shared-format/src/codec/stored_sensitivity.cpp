#include "codec/stored_sensitivity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/LU>

#include "codec/rotations.h"
#include "codec/scales.h"
#include "codec/symmetric3.h"

namespace fluxgs::codec {
namespace {

using Eigen::Matrix3d;

constexpr double kMinRoot = 0.02;    // of the mean
constexpr double kMaxWeight = 1e30;  // whatever comes in, sums are finite

/// Jᵀ·H·J for the triangles of H, where errors of what is stored become J times as much of what
/// they cost for.
template <class Jacobian>
std::vector<float> turned(std::span<const float> sensitivity, const Jacobian& jacobian) {
  std::vector<float> result;
  result.reserve(sensitivity.size());
  for (std::size_t i = 0; i < sensitivity.size() / kSymmetric3; ++i) {
    const Matrix3d j = jacobian(i);
    const Matrix3d h = j.transpose() * symmetric(symmetric3_of(sensitivity, i)) * j;
    const Symmetric3 own = lower_triangle(h.cwiseMax(-kMaxWeight).cwiseMin(kMaxWeight));
    result.insert(result.end(), own.begin(), own.end());
  }
  return result;
}

}  // namespace

std::vector<float> sensitivity_of_roots(std::span<const float> sensitivity,
                                        std::span<const glm::vec3> log_scales) {
  if (sensitivity.empty()) return {};
  const double least = kMinRoot * std::exp(mean_log_scale(log_scales) / 2);
  return turned(sensitivity, [&](std::size_t i) {
    Matrix3d j = Matrix3d::Zero();
    for (int c = 0; c < 3; ++c)
      j(c, c) = 2 / std::max(std::exp(double{log_scales[i][c]} / 2), least);  // d(ln r²)/dr
    return j;
  });
}

std::vector<float> sensitivity_of_rotations(std::span<const float> sensitivity,
                                            std::span<const glm::quat> rotations) {
  return turned(sensitivity, [&](std::size_t i) -> Matrix3d {
    // A turn by e makes (1, e/2)·q of q: e moves x, y, z by half of w·e + e × (x, y, z)
    const glm::quat q = full_rotation(reduced_rotation(rotations[i]));
    const double w = q.w, x = q.x, y = q.y, z = q.z;
    Matrix3d moved;
    moved << w, z, -y,  //
        -z, w, x,       //
        y, -x, w;
    return 2 * moved.inverse();
  });
}

std::vector<float> mean_sensitivity(std::span<const float> sensitivity) {
  std::vector<float> result(sensitivity.size() / kSymmetric3);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = static_cast<float>(symmetric(symmetric3_of(sensitivity, i)).trace() / 3);
  return result;
}

}  // namespace fluxgs::codec
