// Mean steps and weights of a scene. A part of a scene that is encoded with the means of the whole
// is as exact as within the whole.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::codec {

/// Means over the splats of a cloud, natural logarithms: the step of scales grows with the mean
/// scale (scales.h), and that of the others is the one given for a splat of mean importance
/// (perceptual_weight.h).
struct StepMeans {
  double log_scale = 0, opacity = 0, rotation = 0, color = 0;
};

/// Means of a finite cloud with at least one splat.
StepMeans step_means(const SplatCloud& cloud);

/// The steps for a part of a scene with which its splats get the same quantization as they would
/// within the whole with `steps`.
QuantizationSteps steps_within(const QuantizationSteps& steps, const StepMeans& part,
                               const StepMeans& whole);

/// Multiples of CompactOptions::rate_weight for each attribute.
struct RateFactors {
  double scale = 1, opacity = 1, rotation = 1, color = 1;
};

/// Costs of errors of a scene's splats, in steps.
class RateWeights {
 public:
  /// Takes a finite cloud and the costs of its splats, if there are any.
  RateWeights(const SplatCloud& whole, const SensitivityWeights& sensitivity);

  /// For a part of the scene, whose weights are to count as within the whole although those of each
  /// stream are 1 on the average: how much less than the mean they count.
  RateFactors of(std::span<const std::uint32_t> part) const;

 private:
  std::vector<double> scale_, opacity_, rotation_, color_;  ///< a splat; empty: nothing is known
};

}  // namespace fluxgs::codec
