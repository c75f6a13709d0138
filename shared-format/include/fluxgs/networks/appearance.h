// Colours that a scene stores as the input of two small networks (the Flux-GS paper, "Monte Carlo
// Specular Energy Aggregator" and "Gaussian Attribute Awareness"): evaluated once when the scene is
// opened and baked into plain SH of degree 1.
//
//   c′ = Ψ(E, f(μ̂))                 12 + 3 → 12
//   c  = c′ + Φ(μ̂, ŝ, r, o, ĉ′)     3 + 3 + 4 + 1 + 12 → 12
//
// Without Ψ, c′ are the scene's own coefficients (of degree 1; zeros where it has only degree 0).
// Without Φ, c = c′.
//
// Every row holds, in this order and in the units of a SplatCloud,
//   energy     E: E_mag (r, g, b), then E_dir along x (r, g, b), along y, along z
//   position   μ̂ = (μ − center) / extent. Ψ gets it contracted to a ball of radius 2:
//              f(μ̂) = μ̂ where |μ̂| ≤ 1, (2 − 1/|μ̂|)·μ̂/|μ̂| beyond
//   scale      ŝ = (log_scale − log_scale_mean) / log_scale_deviation, of the three axes in the
//              order of the cloud
//   rotation   r = (w, x, y, z): the unit quaternion with w ≥ 0 (if w = 0, the first of x, y, z
//              that is not 0 is positive); the identity for a quaternion of zeros
//   opacity    o = sigmoid(logit), 0…1
//   sh         c: coefficients 0 to 3 (basis of math/spherical_harmonics.h: constant, −y, z, −x),
//              each (r, g, b). Φ gets ĉ′ = (c′ − sh_mean) / sh_deviation
// computed in float64 and rounded to float32. Every entry is limited to ±64, so that no outlier
// can carry a network to infinity.
//
// Both are ONNX models of float32 (operators: src/networks/onnx_check.h; bounds: onnx_model.h) with
// the inputs "energy" and "position" (Ψ), "position", "scale", "rotation", "opacity" and "sh" (Φ),
// each a matrix [N, columns] with any number of rows N, and the outputs "sh" (Ψ) and "offset" (Φ)
// [N, 12].
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "fluxgs/networks/mlp.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::networks {

inline constexpr int kEnergyColumns = 12;                       ///< E_mag and E_dir
inline constexpr int kShColumns = 12;                           ///< degree 0 and 1, RGB
inline constexpr int kPsiColumns = kEnergyColumns + 3;          ///< inputs of Ψ
inline constexpr int kPhiColumns = 3 + 3 + 4 + 1 + kShColumns;  ///< inputs of Φ
inline constexpr float kInputLimit = 64;                        ///< of every input, ±

/// Constants that a scene file carries besides the networks. All values are finite; extent and
/// deviations are at least 1e-6.
struct Normalisation {
  glm::vec3 center{0};                      ///< scene units
  float extent = 1;                         ///< scene units
  float log_scale_mean = 0;                 ///< of all axes
  float log_scale_deviation = 1;            ///< of all axes
  std::array<float, kShColumns> sh_mean{};  ///< of each coefficient
  /// Standard deviation of each coefficient.
  std::array<float, kShColumns> sh_deviation = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
};

/// Constants that suit a scene of degree 1 or more: the median of each coordinate, the 90th
/// percentile of the distance to it, means and standard deviations.
Normalisation measure_normalisation(const SplatCloud& cloud);

/// Names and columns of the inputs and the output of Ψ.
const Signature& psi_signature();
/// The same of Φ.
const Signature& phi_signature();

/// Inputs of Φ for a splat besides its colour, in the units of a SplatCloud.
struct SplatAttributes {
  glm::vec3 position;   ///< scene units
  glm::vec3 log_scale;  ///< natural logarithms
  glm::quat rotation;   ///< any non-zero length
  float opacity_logit;  ///< opacity = sigmoid(logit)
};

/// The row that Ψ gets for a splat; `energy` has kEnergyColumns entries.
std::array<float, kPsiColumns> psi_row(const Normalisation& normalisation,
                                       const glm::vec3& position, std::span<const float> energy);
/// The row that Φ gets for a splat; `sh` (the c′) has kShColumns entries.
std::array<float, kPhiColumns> phi_row(const Normalisation& normalisation,
                                       const SplatAttributes& splat, std::span<const float> sh);

/// The same for splat i of a cloud.
std::array<float, kPsiColumns> psi_row(const Normalisation& normalisation, const SplatCloud& cloud,
                                       std::size_t i, std::span<const float> energy);
/// The same for splat i of a cloud.
std::array<float, kPhiColumns> phi_row(const Normalisation& normalisation, const SplatCloud& cloud,
                                       std::size_t i, std::span<const float> sh);

/// The two models as bytes; either may be empty.
struct AppearanceNetworks {
  std::vector<std::byte> psi;  ///< ONNX
  std::vector<std::byte> phi;  ///< ONNX
};

/// Replace the colours of a finite cloud of degree 0 or 1 by what the networks make of them; it has
/// degree 1 then. `energy` holds kEnergyColumns finite values a splat, and nothing without Ψ.
/// Without networks nothing changes and onnxruntime is not loaded. One thread, in batches: memory
/// beyond the cloud is that of the models (each at most 4 MiB, about four times), 16 MiB and
/// onnxruntime itself. Errors name the file, the network and what is wrong with it; the cloud's
/// colours are then of no use.
Expected<void> bake_appearance(SplatCloud& cloud, std::span<const float> energy,
                               const AppearanceNetworks& networks,
                               const Normalisation& normalisation, const std::string& name);

}  // namespace fluxgs::networks
