// Scales as they are stored: square roots of standard deviations, so that those of large splats are
// more exact: d√σ = ½·√σ·d(ln σ).
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace fluxgs::codec {

/// The step of roots that is a step of `log_step` for a splat of the mean logarithm.
float root_step(std::span<const glm::vec3> log_scales, float log_step);

/// Three roots a splat. Those of more than 2²⁶ steps, which fill any picture, are cut.
std::vector<float> roots_of(std::span<const glm::vec3> log_scales, float step);

/// Back, in place. Roots below 1/16 of the step, to which rounding leads, count as that much.
void roots_to_logs(std::span<float> roots, float step);

}  // namespace fluxgs::codec
