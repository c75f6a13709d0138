// Quantization-aware training: the last iterations train the values that a compact file will hold.
// Renders, and so gradients, are those of the quantized scene; updates go to the unquantized
// values, which are quantized anew now and then (the straight-through estimator, Bengio et al.
// 2013). The paper tunes its codebooks in the same way ("Attributes Compression").
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/compact_glb.h"
#include "trainer/model/phase.h"

namespace fluxgs {

enum class QuantizeAware { off, on, automatic };
inline constexpr std::array<std::string_view, 3> kQuantizeAwareNames = {"off", "on", "auto"};

struct QuantizationAwareOptions {
  static constexpr const char* kTitle = "Quantization-aware training";
  QuantizeAware mode = QuantizeAware::off;  ///< automatic: where the result is a compact file
  int from = 0;                             ///< iteration; 0: after 9/10 of the run
  int interval = 0;  ///< iterations until quantized anew; 0: a thousandth of the run, at least 40
  bool has_networks = false;  ///< make colours, which are not quantized; set by the schedule

  OptionFields fields(const TrainOptions& all);
};

/// Names of the values that quantization attaches to splats: quantized − unquantized parameters,
/// and the sensitivity of the images to their errors.
inline constexpr const char* kQuantizationOffsets = "quantization offsets";
inline constexpr const char* kSensitivity = "sensitivity";

/// Attaches sensitivities that quantize_parameters() uses.
void attach_sensitivity(TrainState& state, const SensitivityWeights& sensitivity);

/// Quantizes the parameters of a state, less their last offsets if there are any, by the attached
/// sensitivities. The splats then have the order of the file, in which those of equal depth are
/// drawn; the optimiser's moments of rotations follow these to where a file's quaternions lie.
/// `filter` is that of the scene.
/// Returns the file, which holds exactly this scene. On an error, which names the attribute,
/// nothing has changed.
Expected<std::vector<std::byte>> quantize_parameters(TrainState& state,
                                                     const QuantizationSteps& steps,
                                                     const ScreenFilter& filter = {});

/// Resolves the options. Null where training is not quantization-aware. `settled`: the last
/// iteration at which the number or the SH degrees of splats change.
std::unique_ptr<Phase> make_quantization_aware(TrainOptions& options, int settled);

}  // namespace fluxgs
