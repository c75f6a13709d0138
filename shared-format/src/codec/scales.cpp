#include "codec/scales.h"

#include <algorithm>
#include <cmath>

namespace fluxgs::codec {
namespace {

constexpr double kMostSteps = 0x1p26, kLeastSteps = 0x1p-4;
constexpr double kLongest = 50;  // logarithms beyond would set the mean

}  // namespace

float root_step(std::span<const glm::vec3> log_scales, float log_step) {
  double sum = 0;
  for (const glm::vec3& s : log_scales)
    for (int c = 0; c < 3; ++c) sum += std::clamp(double{s[c]}, -kLongest, kLongest);
  const double mean = sum / (3 * static_cast<double>(log_scales.size()));
  return static_cast<float>(std::clamp(0.5 * double{log_step} * std::exp(mean / 2), 1e-30, 1e30));
}

std::vector<float> roots_of(std::span<const glm::vec3> log_scales, float step) {
  std::vector<float> roots;
  roots.reserve(3 * log_scales.size());
  const double most = kMostSteps * double{step};
  for (const glm::vec3& s : log_scales)
    for (int c = 0; c < 3; ++c)
      roots.push_back(static_cast<float>(std::min(std::exp(double{s[c]} / 2), most)));
  return roots;
}

void roots_to_logs(std::span<float> roots, float step) {
  const float least = std::max(static_cast<float>(kLeastSteps * double{step}), 1e-30f);
  for (float& x : roots) x = 2 * std::log(std::max(x, least));
}

}  // namespace fluxgs::codec
