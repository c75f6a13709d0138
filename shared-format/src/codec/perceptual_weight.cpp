#include "codec/perceptual_weight.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "codec/deterministic_math.h"

namespace fluxgs::codec {
namespace {

constexpr float kFlattest = 6.5f;            // thinner ones look the same
constexpr float kMinVisible = 1e-3f;         // splats of lower opacity are not drawn
constexpr float kLargestLogit = 700;         // within what portable_exp() takes
constexpr float kFinest = 6, kCoarsest = 2;  // logarithms of the step over the mean one

double average(std::span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += double{value};
  return sum / static_cast<double>(values.size());
}

/// Logarithms of 1/step.
std::vector<float> log_inverse_steps(const PerceptualWeight& perceptual_weight,
                                     std::span<const LogExtents> extents) {
  std::vector<float> result;
  result.reserve(extents.size());
  for (const LogExtents& extent : extents) result.push_back(glm::dot(perceptual_weight, extent));
  return result;
}

}  // namespace

std::vector<LogExtents> extents_of(std::span<const glm::vec3> log_scales) {
  std::vector<LogExtents> extents;
  extents.reserve(log_scales.size());
  for (const glm::vec3& scales : log_scales) {
    const glm::vec3 s = glm::clamp(scales, -kLongest, kLongest);
    const float longest = std::max({s.x, s.y, s.z}), shortest = std::min({s.x, s.y, s.z});
    const float middle = std::max(std::min(s.x, s.y), std::min(std::max(s.x, s.y), s.z));
    const float least = longest - kFlattest;
    extents.emplace_back(longest, std::max(middle, least), std::max(shortest, least), 0.0f);
  }
  return extents;
}

// Clamping has branches, and a loop of its own: the others are vectorised.
void set_opacities(std::span<LogExtents> extents, std::span<const float> opacity_logits) {
  std::vector<float> x(opacity_logits.begin(), opacity_logits.end());
  for (float& v : x) v = std::clamp(v, -kLargestLogit, kLargestLogit);
  for (float& v : x) v = static_cast<float>(1 / (1 + portable_exp(-double{v})));
  for (float& v : x) v = std::max(v, kMinVisible);
  for (float& v : x) v = static_cast<float>(portable_log(double{v}));
  for (std::size_t i = 0; i < extents.size(); ++i) extents[i].w = x[i];
}

double mean_perceptual_weight(const PerceptualWeight& perceptual_weight,
                              std::span<const LogExtents> extents) {
  return average(log_inverse_steps(perceptual_weight, extents));
}

std::vector<float> step_scale_of(const PerceptualWeight& perceptual_weight,
                                 std::span<const LogExtents> extents) {
  std::vector<float> result = log_inverse_steps(perceptual_weight, extents);
  const auto mean = static_cast<float>(average(result));
  for (float& x : result) x = std::clamp(mean - x, -kFinest, kCoarsest);
  for (float& x : result) x = static_cast<float>(portable_exp(double{x}));
  return result;
}

}  // namespace fluxgs::codec
