// The compact .glb: KHR_gaussian_splatting whose splats are held by our own nested extension
// FLUXGS_gaussian_splatting_compact (shared-format/schema/). Read by read_glb().
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/sensitivity_weights.h"
#include "fluxgs/networks/appearance.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// Name of the extension, in SceneFile::extensions of a compact .glb.
inline constexpr char kCompactExtension[] = "FLUXGS_gaussian_splatting_compact";

/// Quantization step of each attribute: smaller steps, more bytes, less error. All > 0. Those of
/// positions are the same everywhere, the others hold for splats of ordinary size and opacity;
/// large and opaque ones are quantized less (perceptual_weight.h).
struct QuantizationSteps {
  double position = 1e-3;  ///< scene units
  float log_scale = 0.2f;  ///< of the natural logarithm
  float rotation = 0.06f;  ///< of the quaternion's x, y, z
  float opacity = 0.06f;   ///< of asin(√opacity)·2/π, 0…1
  float sh_dc = 0.08f;     ///< of the coefficient, 0.28 of which is colour
  float sh_rest = 0.1f;    ///< of the coefficients of degrees 1 to 3
  float energy = 0.1f;     ///< of the networks' input, which then stands for the two above
};

/// Steps that suit most scenes, times `step scale` (> 0): at 1, images of scans and of scenes
/// trained from images are about 40 dB from those of the uncompressed scene. Positions are
/// quantized relative to the median size of the splats, or as finely as a file can.
QuantizationSteps default_quantization_steps(const SplatCloud& cloud, double step_scale = 1);

/// The finest step of positions that a file can have: it counts fewer than 2²⁴ along an axis.
double finest_position_step(const SplatCloud& cloud);

/// The extent along an axis up to which default_quantization_steps() quantizes positions as the
/// size of the splats asks.
double largest_fine_extent(const SplatCloud& cloud, double step_scale = 1);

/// Every step times `factor`.
QuantizationSteps scaled(const QuantizationSteps& steps, double factor);

/// Worth of a bit in squared steps of error when values are quantized. At fine steps, where a
/// bit more quarters the mean square error of step²/12, it is 2·ln 2/12.
inline constexpr double kDefaultRateWeight = 0.115;

/// Makes the rotations those that a compact file stores, before they are quantized: unit
/// quaternions, and of the four that differ by half turns about the splat's own axes, and so have
/// the same covariance, the one with the largest w in glTF's frame.
void canonicalize_rotations(SplatCloud& cloud);
glm::quat canonical_rotation(const glm::quat& rotation);  ///< of one splat

/// Networks that make the colours when the scene is opened (networks/appearance.h). They know the
/// scene in glTF's frame (turn_gltf_frame()): positions, rotations and SH coefficients, and the
/// energy.
struct CompactNetworks {
  networks::AppearanceNetworks models;         ///< one of them at least
  networks::Normalisation normalisation = {};  ///< of the networks' inputs
  std::vector<float> energy = {};  ///< with Ψ: 12 finite values a splat, in the order of the cloud
};

/// Options of encode_compact_glb().
struct CompactOptions {
  QuantizationSteps steps = {};   ///< see default_quantization_steps()
  bool plain_attributes = false;  ///< also store what is decoded as plain floats, see below
  double rate_weight = kDefaultRateWeight;  ///< ≥ 0; 0 rounds to the nearest
  /// Costs of errors when values are quantized. For scenes with networks, weights only.
  SensitivityWeights sensitivity = {};
  /// The cloud is then of degree 1, and its colours are what Φ begins with; with Ψ they are not
  /// stored. Φ gets rotations as the file has them: it must know them as canonicalize_rotations()
  /// makes them. What is written is run once as a check, for which onnxruntime must be here.
  std::optional<CompactNetworks> networks = {};
  /// Scenes of 24,000 splats or more in four chunks, those that add most first, so that the first
  /// tenth of the file shows it already. With splats of several degrees each chunk has a primitive
  /// for each, and scenes are stored so where these have 6,000 splats on the average.
  bool in_chunks = true;
};

/// Order of a finite cloud's splats in its compact file: order[k] is the index in the cloud of
/// splat k of the file. It depends on the step of positions.
std::vector<std::uint32_t> compact_order(const SplatCloud& cloud,
                                         const CompactOptions& options = {});

/// Write one node with a POINTS primitive for each degree that splats need (sh_degree_of()), lowest
/// first, each in the Z-order of its positions' cells; the file's degree is the highest of them. A
/// degree that fewer than 512 splats need is not worth a primitive: they go into the next one,
/// where the bands that they lack are zeros, quantized as others are. With networks all splats are
/// in one primitive of degree 1. Without plain attributes the file is smallest, and the extension
/// is listed as required; with them it is larger than encode_glb's, and opens in every viewer of
/// KHR_gaussian_splatting. Splats with a NaN or infinity are left out. Scales of e^18 times the
/// mean or more are cut to that. A scene without splats is written without a mesh. An error names
/// an attribute whose values are beyond its step's reach, or costs that do not fit the cloud.
Expected<std::vector<std::byte>> encode_compact_glb(const SplatCloud& cloud,
                                                    const CompactOptions& options,
                                                    const std::string& name);

}  // namespace fluxgs
