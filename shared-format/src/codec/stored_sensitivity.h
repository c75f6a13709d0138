// Sensitivity to errors of stored scales and rotations.
#pragma once

#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace fluxgs::codec {

/// SensitivityWeights::scale for the roots of standard deviations (scales.h) instead of their
/// logarithms. Those of splats that are thousands of times thinner than the mean count as a little
/// less thin.
std::vector<float> sensitivity_of_roots(std::span<const float> sensitivity,
                                        std::span<const glm::vec3> log_scales);

/// SensitivityWeights::rotation for what is stored of quaternions (rotations.h) instead of turns.
std::vector<float> sensitivity_of_rotations(std::span<const float> sensitivity,
                                            std::span<const glm::quat> rotations);

/// The mean of each splat's diagonal: as weights of errors.
std::vector<float> mean_sensitivity(std::span<const float> sensitivity);

}  // namespace fluxgs::codec
