#include "fluxgs/transform.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "fluxgs/math/projection.h"
#include "fluxgs/math/sh_rotation.h"

namespace fluxgs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Svd = Eigen::JacobiSVD<Matrix3d>;

constexpr double kFlat = 1e12;
// Single-precision matrices of turns and even scales are better than this; within it no
// decomposition is needed, which would give a splat's axes another order.
constexpr double kEven = 1 + 1e-5;

Matrix3d eigen_of(const glm::dmat3& m) { return Eigen::Map<const Matrix3d>(&m[0][0]); }

Svd decomposed(const Matrix3d& m) { return Svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV); }

glm::dquat quat_of(const Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return glm::dquat(q.w(), q.x(), q.y(), q.z());
}

/// The parts of a map that act on every splat.
struct Parts {
  Matrix3d linear;
  Matrix3d turn;  ///< a rotation
  bool mirrored;  ///< a mirror at the origin, p ↦ −p, before the turn: no Gaussian notices it
  bool even;      ///< linear = ±scale·turn
  double log_scale;
  math::ShRotation sh;
};

Parts parts_of(const glm::dmat3& linear) {
  const Svd svd = decomposed(eigen_of(linear));
  Parts parts{};
  parts.linear = eigen_of(linear);
  parts.turn = svd.matrixU() * svd.matrixV().transpose();
  parts.mirrored = parts.turn.determinant() < 0;
  if (parts.mirrored) parts.turn = -parts.turn;
  const Vector3d& values = svd.singularValues();
  parts.even = values[0] <= kEven * values[2];
  parts.log_scale = values.array().log().mean();
  const Matrix3d& r = parts.turn;
  parts.sh = math::make_sh_rotation(
      {{r(0, 0), r(0, 1), r(0, 2)}, {r(1, 0), r(1, 1), r(1, 2)}, {r(2, 0), r(2, 1), r(2, 2)}});
  return parts;
}

/// The shape of a splat under a map that stretches.
void stretch_shape(const Matrix3d& linear, glm::quat& rotation, glm::vec3& log_scale) {
  const math::Quat<double> q =
      math::normalized(math::Quat<double>{rotation.w, rotation.x, rotation.y, rotation.z});
  // Relative to the largest, so that no square leaves the range of double
  const double largest = std::max({log_scale.x, log_scale.y, log_scale.z});
  Matrix3d shape = linear * Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  for (int c = 0; c < 3; ++c) shape.col(c) *= std::exp(double{log_scale[c]} - largest);
  if (!shape.allFinite()) {  // is dropped with other splats that are not finite
    log_scale = glm::vec3(std::numeric_limits<float>::quiet_NaN());
    return;
  }
  const Svd svd = decomposed(shape);
  Matrix3d axes = svd.matrixU();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  rotation = glm::quat(quat_of(axes));
  for (int c = 0; c < 3; ++c) {
    const double value = std::max(svd.singularValues()[c], std::numeric_limits<double>::min());
    log_scale[c] = static_cast<float>(largest + std::log(value));
  }
}

void transform_colours(const Parts& parts, int sh_degree, glm::vec3* rest) {
  if (parts.mirrored)  // a basis function of an odd degree changes its sign at −d
    for (int k = 0; k < sh_rest_count(sh_degree); ++k)
      if (k < 3 || k >= 8) rest[k] = -rest[k];
  math::rotate_sh(parts.sh, sh_degree, rest);
}

}  // namespace

double stretch_of(const glm::dmat3& linear) {
  const Matrix3d m = eigen_of(linear);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (!m.allFinite() || m.isZero(0)) return kInfinite;
  const Vector3d values = decomposed(m / m.cwiseAbs().maxCoeff()).singularValues();
  return values[0] < kFlat * values[2] ? values[0] / values[2] : kInfinite;
}

void transform_splats(const AffineMap& map, SplatCloud& cloud, std::size_t begin, std::size_t end) {
  if (map == AffineMap{}) return;
  const Parts parts = parts_of(map.linear);
  const glm::dquat turn = quat_of(parts.turn);
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t i = begin; i < end; ++i) {
    cloud.positions[i] = glm::vec3(map.linear * glm::dvec3(cloud.positions[i]) + map.translation);
    if (parts.even) {
      cloud.rotations[i] = glm::quat(turn * glm::dquat(cloud.rotations[i]));
      for (int c = 0; c < 3; ++c)
        cloud.log_scales[i][c] =
            static_cast<float>(double{cloud.log_scales[i][c]} + parts.log_scale);
    } else {
      stretch_shape(parts.linear, cloud.rotations[i], cloud.log_scales[i]);
    }
    transform_colours(parts, cloud.sh_degree, cloud.sh_rest.data() + i * rest);
  }
}

}  // namespace fluxgs
