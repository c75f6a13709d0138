// Scales as they are stored: square roots of standard deviations, so that those of large splats are
// more exact: d√σ = ½·√σ·d(ln σ).
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace fluxgs::codec {

/// Values of all splats and what they are quantized to.
struct Stepped {
  std::vector<float> values;
  float step = 1;
};

/// The mean of the logarithms, each counted as −50 to 50.
double mean_log_scale(std::span<const glm::vec3> log_scales);

/// Three roots a splat; their step is one of `log_step` for a splat of the mean logarithm. Those of
/// e^18 times the mean standard deviation, or of more than 2²⁶ steps, fill any image and are cut.
Stepped roots_of(std::span<const glm::vec3> log_scales, float log_step);

/// Back, in place. Roots below 1/16 of the step, to which rounding leads, count as that much.
void roots_to_logs(std::span<float> roots, float step);

}  // namespace fluxgs::codec
