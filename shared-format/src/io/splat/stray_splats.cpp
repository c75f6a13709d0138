#include "fluxgs/io/stray_splats.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "io/splat/scene_core.h"

namespace fluxgs {
namespace {

constexpr std::size_t kOneOf = 1000, kAtLeast = 3;  // splats that are few

/// Natural logarithms of standard deviations.
struct SizeRange {
  float low, high;
};

/// About the median size of one or more splats. Narrower where they are so few that one of them
/// moves their mean, which the steps of compact files grow with.
SizeRange size_range(const SplatCloud& cloud) {
  const float usual = std::clamp(static_cast<float>(io::median_log_size(cloud)), -30.0F, 30.0F);
  const auto few = 2 + static_cast<float>(cloud.size());
  return {.low = usual - std::min(12.0F, few), .high = usual + std::min(16.0F, few)};
}

}  // namespace

double median_distance(const SplatCloud& cloud) {
  return cloud.size() == 0 ? 0 : io::scene_core(cloud.positions).radius;
}

std::size_t pull_in_stray_splats(SplatCloud& cloud, double extent) {
  if (cloud.size() == 0) return 0;
  const io::SceneCore core = io::scene_core(cloud.positions);
  std::vector<std::pair<std::size_t, double>> stray;  // and the factor of its distance
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 d = glm::abs(glm::dvec3(cloud.positions[i]) - core.center);
    const double farthest = std::max({d.x, d.y, d.z});
    if (farthest > extent / 2) stray.emplace_back(i, extent / 2 / farthest);
  }
  if (stray.size() > std::max(kAtLeast, cloud.size() / kOneOf)) return 0;
  const float smallest = size_range(cloud).low;
  for (const auto& [i, factor] : stray) {
    const glm::vec3 before = cloud.log_scales[i];
    io::pull_in(cloud, i, core, factor);
    cloud.log_scales[i] = glm::max(cloud.log_scales[i], glm::min(before, glm::vec3(smallest)));
  }
  return stray.size();
}

std::size_t limit_stray_sizes(SplatCloud& cloud) {
  if (cloud.size() == 0) return 0;
  const auto [low, high] = size_range(cloud);
  std::size_t larger = 0;
  for (glm::vec3& s : cloud.log_scales) {
    larger += std::max({s.x, s.y, s.z}) > high ? 1 : 0;
    s = glm::clamp(s, low, high);
  }
  return larger;
}

std::size_t limit_stray_colors(SplatCloud& cloud) {
  constexpr float kTimes = 10, kWhite = 2;  // the constant coefficient of white is 1.8
  const std::size_t size = cloud.size(), few = std::max(kAtLeast, size / kOneOf);
  if (size <= few) return 0;
  const std::size_t rest = cloud.sh_rest.size() / size;
  const auto largest = [](const glm::vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  };
  std::vector<bool> changed(size, false);
  const auto limit = [&](std::vector<glm::vec3>& values, std::size_t each, std::size_t k) {
    std::vector<float> sorted(size);
    for (std::size_t i = 0; i < size; ++i) sorted[i] = largest(values[i * each + k]);
    const auto usual = sorted.begin() + static_cast<std::ptrdiff_t>(few);
    std::ranges::nth_element(sorted, usual, std::greater{});
    const float most = kTimes * std::max(*usual, kWhite);
    for (std::size_t i = 0; i < size; ++i) {
      glm::vec3& value = values[i * each + k];
      if (largest(value) <= most) continue;
      value = glm::clamp(value, -most, most);
      changed[i] = true;
    }
  };
  limit(cloud.sh_dc, 1, 0);
  for (std::size_t k = 0; k < rest; ++k) limit(cloud.sh_rest, rest, k);
  return static_cast<std::size_t>(std::ranges::count(changed, true));
}

}  // namespace fluxgs
