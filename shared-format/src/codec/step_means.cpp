#include "codec/step_means.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "codec/importance.h"
#include "codec/scales.h"

namespace fluxgs::codec {
namespace {

/// A ratio of steps that undoes one of means; within the range of float.
float times(float step, double logarithm) {
  constexpr double kMost = 40;
  return static_cast<float>(double{step} * std::exp(std::clamp(logarithm, -kMost, kMost)));
}

}  // namespace

StepMeans step_means(const SplatCloud& cloud) {
  StepMeans means{.log_scale = mean_log_scale(cloud.log_scales)};
  std::vector<Extent> extents = extents_of(cloud.log_scales);
  means.opacity = mean_importance(kOpacityImportance, extents);
  set_opacities(extents, cloud.opacity_logits);
  means.rotation = mean_importance(kRotationImportance, extents);
  means.color = mean_importance(kColorImportance, extents);
  return means;
}

CompactSteps steps_within(const CompactSteps& steps, const StepMeans& part,
                          const StepMeans& whole) {
  CompactSteps result = steps;
  // Of roots: half the logarithm
  result.log_scale = times(steps.log_scale, (whole.log_scale - part.log_scale) / 2);
  result.opacity = times(steps.opacity, whole.opacity - part.opacity);
  result.rotation = times(steps.rotation, whole.rotation - part.rotation);
  result.sh_dc = times(steps.sh_dc, whole.color - part.color);
  result.sh_rest = times(steps.sh_rest, whole.color - part.color);
  return result;
}

}  // namespace fluxgs::codec
