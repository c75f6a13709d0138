// How exactly each splat is worth storing, told from attributes that are decoded before.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace fluxgs::codec {

/// Natural logarithms of a splat's standard deviations, longest first, and of its opacity. Lengths
/// count as e^±kLongest at most, axes as no shorter than e^−6.5 of the longest, opacities as no
/// less than 0.001.
using Extent = glm::vec4;

/// Logarithms of lengths beyond ± this count as this: one splat alone must not set a mean.
inline constexpr float kLongest = 50;

/// The extents of splats whose opacities are not known: they count as 1.
std::vector<Extent> extents_of(std::span<const glm::vec3> log_scales);
void set_opacities(std::span<Extent> extents, std::span<const float> opacity_logits);

/// A splat's step is proportional to longest^−a · middle^−b · shortest^−c · opacity^−d. Errors of
/// large and opaque splats are seen in more pixels, and a turn moves the ends of a long one
/// further.
using Importance = glm::vec4;  // a, b, c, d

// Measured: at equal error of the images, scenes trained from images take 5 to 25% less with
// these than with equal steps and logarithms of the scales; others within ±0.1 change little.
inline constexpr Importance kOpacityImportance{0.15f, 0.15f, 0, 0};
inline constexpr Importance kRotationImportance{0.8f, 0.15f, -0.2f, 0.2f};
inline constexpr Importance kColorImportance{0.4f, 0.3f, 0, 0.3f};

/// The mean over the splats of the logarithm of 1/step.
double mean_importance(const Importance& importance, std::span<const Extent> extents);

/// Coarseness (channels.h) of each splat: 1 at the geometric mean of the splats' steps, e^−6 to e²
/// at most.
std::vector<float> coarseness_of(const Importance& importance, std::span<const Extent> extents);

}  // namespace fluxgs::codec
