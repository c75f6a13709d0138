// Maps of space applied to splats: nodes of glTF, and scenes that are turned or resized.
#pragma once

#include <cstddef>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// p ↦ linear·p + translation.
struct AffineMap {
  glm::dmat3 linear{1.0};       ///< glm is column-major: linear[column][row]
  glm::dvec3 translation{0.0};  ///< scene units

  /// True if all numbers are equal.
  friend bool operator==(const AffineMap&, const AffineMap&) = default;
};

/// Ratio of the largest to the smallest singular value of a matrix, ≥ 1: 1 for turns, mirrors and
/// even scales. Infinite for a matrix that flattens space (beyond 10¹²) or is not finite.
double stretch_of(const glm::dmat3& linear);

/// Maps the splats `begin` … `end` − 1. `map` must be finite and its stretch_of() too.
///
/// A Gaussian stays a Gaussian: its covariance C becomes L·C·Lᵀ, which has axes and standard
/// deviations again (a singular value decomposition of L·R·S, where C = R·S²·Rᵀ). Its colours as a
/// function of direction turn with L: exactly for turns, mirrors and even scales of them. Where L
/// stretches, harmonics of a degree do not suffice, and they follow the turn (and mirror) nearest
/// to L, the orthogonal factor of its polar decomposition, as KHR_gaussian_splatting asks ("the
/// rotation component").
void transform_splats(const AffineMap& map, SplatCloud& cloud, std::size_t begin, std::size_t end);

}  // namespace fluxgs
