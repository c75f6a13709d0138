#include "io/splat/scene_core.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::io {
namespace {

/// The middle one of the values. Where two are, it is the one nearer to 0: the other may be a stray
/// splat's, of two splats.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  const double below = *std::max_element(values.begin(), middle);
  return std::abs(below) < std::abs(*middle) ? below : *middle;
}

}  // namespace

SceneCore scene_core(const std::vector<glm::vec3>& positions) {
  SceneCore core;
  std::vector<double> values(positions.size());
  for (int c = 0; c < 3; ++c) {
    std::ranges::transform(positions, values.begin(), [c](const glm::vec3& p) { return p[c]; });
    core.center[c] = median(values);
  }
  std::ranges::transform(positions, values.begin(), [&](const glm::vec3& p) {
    return glm::distance(glm::dvec3(p), core.center);
  });
  core.radius = median(values);
  return core;
}

double median_log_size(const SplatCloud& cloud) {
  std::vector<float> sizes;
  sizes.reserve(cloud.size());
  for (const glm::vec3& s : cloud.log_scales)
    if (const float mean = (s.x + s.y + s.z) / 3; std::isfinite(mean)) sizes.push_back(mean);
  if (sizes.empty()) return 0;
  const std::size_t half = sizes.size() == 2 ? 0 : sizes.size() / 2;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(half);
  std::ranges::nth_element(sizes, middle);
  return *middle;
}

double factor_within(const glm::vec3& position, const SceneCore& core, double limit) {
  double factor = 1;
  for (int c = 0; c < 3; ++c) {
    const double p = position[c];
    if (std::abs(p) <= limit) continue;
    factor = std::min(factor, (std::copysign(limit, p) - core.center[c]) / (p - core.center[c]));
  }
  return factor;
}

void pull_in(SplatCloud& cloud, std::size_t i, const SceneCore& core, double factor) {
  cloud.positions[i] =
      glm::vec3(core.center + factor * (glm::dvec3(cloud.positions[i]) - core.center));
  cloud.log_scales[i] += static_cast<float>(std::log(factor));
}

}  // namespace fluxgs::io
