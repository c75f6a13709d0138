// Rate-distortion weights: sensitivity of rendered images to quantization errors of each splat.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// Numbers of a lower triangle over the (degree + 1)² basis functions of a degree 0…3.
constexpr std::size_t sh_factor_size(int sh_degree) {
  const auto n = static_cast<std::size_t>(sh_rest_count(sh_degree) + 1);
  return n * (n + 1) / 2;
}

/// Numbers of a lower triangle of 3×3: of rows 1, 2 and 3 one after the other.
inline constexpr std::size_t kSymmetric3 = 6;

/// Each list has as many values for each splat of a cloud, in its order, or none at all where
/// nothing is known. Each is on any scale of its own.
struct SensitivityWeights {
  /// Weight of each splat's errors, such as its contribution to the images Σ α·T: those of
  /// attributes for which there is no better list below. Without any: by area and opacity alone.
  std::vector<float> weights = {};
  /// Directions from which each splat is seen, so that errors of its SH coefficients can be put
  /// where they are not: the lower triangle, row by row, of L in 4π·G = L·Lᵀ, where G is the mean
  /// of y(d)·y(d)ᵀ over the directions d from cameras to the splat, and y the basis functions up to
  /// the cloud's degree, the constant one first. sh_factor_size() values a splat, the diagonal
  /// above 0. Without any: from all sides.
  std::vector<float> sh_factors = {};
  /// The cost of errors e of the three log-scales is eᵀ·H·e: the lower triangle (kSymmetric3) of
  /// the positive semidefinite H.
  std::vector<float> scale = {};
  /// The same for a turn of the splat by e: |e| radians about the axis e of the scene.
  std::vector<float> rotation = {};
};

/// Numbers of all lists together for a splat of this degree.
constexpr std::size_t sensitivity_size(int sh_degree) {
  return 1 + sh_factor_size(sh_degree) + 2 * kSymmetric3;
}

/// Those of splats splats[0], splats[1]… of a cloud of this degree, for one of `new_degree`, which
/// is not higher.
SensitivityWeights sensitivity_of(const SensitivityWeights& sensitivity, int sh_degree,
                                  std::span<const std::uint32_t> splats, int new_degree);

/// An error names what does not fit `cloud` or is no such value.
Expected<void> check_sensitivity(const SensitivityWeights& sensitivity, const SplatCloud& cloud,
                                 const std::string& name);

}  // namespace fluxgs
