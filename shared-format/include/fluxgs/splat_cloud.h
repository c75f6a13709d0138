// The one splat model: a plain struct of arrays that every reader fills and every writer drains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/screen_filter.h"

namespace fluxgs {

/// Coefficients of spherical harmonics (SH) for each colour channel beyond the constant one: 0, 3,
/// 8 or 15.
constexpr int sh_rest_count(int degree) { return (degree + 1) * (degree + 1) - 1; }

/// The highest SH degree that scenes hold here; readers leave out what is above.
inline constexpr int kMaxShDegree = 3;

/// A scene of 3D Gaussians. Frame: that of an INRIA 3DGS .ply (right-handed, y down, z forward for
/// the first COLMAP camera); readers and writers of other conventions convert at the door.
/// Every array has size() entries, sh_rest has size()·sh_rest_count(sh_degree).
struct SplatCloud {
  int sh_degree = 0;    ///< 0…3
  ScreenFilter filter;  ///< to draw it with

  std::vector<glm::vec3> positions;   ///< centre, scene units
  std::vector<glm::vec3> log_scales;  ///< natural logarithm of the standard deviations
  std::vector<glm::quat> rotations;   ///< local → world; any non-zero length
  std::vector<float> opacity_logits;  ///< opacity = sigmoid(logit)
  std::vector<glm::vec3> sh_dc;       ///< degree-0 RGB coefficient; colour = 0.282…·dc + 0.5
  std::vector<glm::vec3> sh_rest;     ///< [splat][coefficient] RGB, degrees 1…sh_degree

  /// Number of splats.
  std::size_t size() const { return positions.size(); }

  /// New splats are zeros with the identity as rotation.
  void resize(std::size_t count) {
    positions.resize(count);
    log_scales.resize(count);
    rotations.resize(count, glm::quat(1, 0, 0, 0));
    opacity_logits.resize(count);
    sh_dc.resize(count);
    sh_rest.resize(count * static_cast<std::size_t>(sh_rest_count(sh_degree)));
  }
};

/// The splats order[0], order[1], … of a cloud.
SplatCloud in_order(const SplatCloud& cloud, std::span<const std::uint32_t> order);

/// Leaves out the SH coefficients beyond a degree; a cloud of that degree or less stays as it is.
void limit_sh_degree(SplatCloud& cloud, int degree);

/// True if every attribute of splat i is a finite number.
bool is_finite(const SplatCloud& cloud, std::size_t i);

/// Number of splats with a NaN or infinity in any attribute.
std::size_t count_non_finite(const SplatCloud& cloud);

/// Remove every splat that has a NaN or infinity in any attribute; the order of the others stays.
/// Returns how many were removed.
std::size_t drop_non_finite(SplatCloud& cloud);

}  // namespace fluxgs
