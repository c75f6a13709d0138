#include "codec/scales.h"

#include <algorithm>
#include <cmath>

#include "codec/deterministic_math.h"
#include "codec/perceptual_weight.h"

namespace fluxgs::codec {
namespace {

constexpr double kMaxRootSteps = 0x1p26, kMinRootSteps = 0x1p-4;
constexpr double kLongestOverMean = 18;

}  // namespace

double mean_log_scale(std::span<const glm::vec3> log_scales) {
  double sum = 0;
  for (const glm::vec3& s : log_scales)
    for (int c = 0; c < 3; ++c) sum += double{std::clamp(s[c], -kLongest, kLongest)};
  return sum / (3 * static_cast<double>(log_scales.size()));
}

Stepped roots_of(std::span<const glm::vec3> log_scales, float log_step) {
  const double mean = mean_log_scale(log_scales);
  const double step = std::clamp(0.5 * double{log_step} * std::exp(mean / 2), 1e-30, 1e30);
  const double most = std::min(std::exp((mean + kLongestOverMean) / 2), kMaxRootSteps * step);
  Stepped roots{.values = {}, .step = static_cast<float>(step)};
  roots.values.reserve(3 * log_scales.size());
  for (const glm::vec3& s : log_scales)
    for (int c = 0; c < 3; ++c)
      roots.values.push_back(static_cast<float>(std::min(std::exp(double{s[c]} / 2), most)));
  return roots;
}

void roots_to_logs(std::span<float> roots, float step) {
  const float least = std::max(static_cast<float>(kMinRootSteps * double{step}), 1e-30f);
  for (float& x : roots) x = 2 * static_cast<float>(portable_log(double{std::max(x, least)}));
}

}  // namespace fluxgs::codec
