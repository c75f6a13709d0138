#include "codec/step_means.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "codec/perceptual_weight.h"
#include "codec/quantization.h"
#include "codec/scales.h"
#include "codec/stored_sensitivity.h"

namespace fluxgs::codec {
namespace {

/// A ratio of steps that undoes one of means; within the range of float.
float times(float step, double logarithm) {
  constexpr double kMax = 40;
  return static_cast<float>(double{step} * std::exp(std::clamp(logarithm, -kMax, kMax)));
}

/// weight·step² of each splat.
std::vector<double> in_steps(std::span<const float> step_scale, std::span<const float> weights) {
  std::vector<double> result(weights.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double c = step_scale.empty() ? 1.0 : double{step_scale[i]};
    result[i] = double{weights[i]} * c * c;
  }
  return result;
}

/// The mean over the whole, over that of the part.
double whole_over_part(std::span<const double> weights, std::span<const std::uint32_t> part) {
  if (weights.empty()) return 1;
  double whole_sum = 0, part_sum = 0;
  for (const double weight : weights) whole_sum += weight;
  for (const std::uint32_t i : part) part_sum += weights[i];
  if (!(whole_sum > 0)) return 1;
  const double share =
      part_sum / whole_sum * static_cast<double>(weights.size()) / static_cast<double>(part.size());
  return 1 / std::clamp(share, kMinWeight, kMaxWeight);
}

}  // namespace

StepMeans step_means(const SplatCloud& cloud) {
  StepMeans means{.log_scale = mean_log_scale(cloud.log_scales)};
  std::vector<LogExtents> extents = extents_of(cloud.log_scales);
  means.opacity = mean_perceptual_weight(kOpacityWeight, extents);
  set_opacities(extents, cloud.opacity_logits);
  means.rotation = mean_perceptual_weight(kRotationWeight, extents);
  means.color = mean_perceptual_weight(kColorWeight, extents);
  return means;
}

QuantizationSteps steps_within(const QuantizationSteps& steps, const StepMeans& part,
                               const StepMeans& whole) {
  QuantizationSteps result = steps;
  // Of roots: half the logarithm
  result.log_scale = times(steps.log_scale, (whole.log_scale - part.log_scale) / 2);
  result.opacity = times(steps.opacity, whole.opacity - part.opacity);
  result.rotation = times(steps.rotation, whole.rotation - part.rotation);
  for (float* step : {&result.sh_dc, &result.sh_rest, &result.energy})
    *step = times(*step, whole.color - part.color);
  return result;
}

RateWeights::RateWeights(const SplatCloud& whole, const SensitivityWeights& sensitivity) {
  std::vector<LogExtents> extents = extents_of(whole.log_scales);
  const auto weigh = [&](const PerceptualWeight& perceptual_weight,
                         std::span<const float> weights) {
    return weights.empty() ? std::vector<double>()
                           : in_steps(step_scale_of(perceptual_weight, extents), weights);
  };
  const auto means_or_weights = [&](const std::vector<float>& own) {
    return own.empty() ? sensitivity.weights : mean_sensitivity(own);
  };
  scale_ = weigh(PerceptualWeight(0),
                 means_or_weights(sensitivity_of_roots(sensitivity.scale, whole.log_scales)));
  opacity_ = weigh(kOpacityWeight, sensitivity.weights);
  set_opacities(extents, whole.opacity_logits);
  rotation_ =
      weigh(kRotationWeight,
            means_or_weights(sensitivity_of_rotations(sensitivity.rotation, whole.rotations)));
  color_ = weigh(kColorWeight, sensitivity.weights);
}

RateFactors RateWeights::of(std::span<const std::uint32_t> part) const {
  return {.scale = whole_over_part(scale_, part),
          .opacity = whole_over_part(opacity_, part),
          .rotation = whole_over_part(rotation_, part),
          .color = whole_over_part(color_, part)};
}

}  // namespace fluxgs::codec
