#include "fluxgs/io/stray_splats.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "io/splat/scene_core.h"

namespace fluxgs {

double median_distance(const SplatCloud& cloud) {
  return cloud.size() == 0 ? 0 : io::scene_core(cloud.positions).radius;
}

std::size_t pull_in_stray_splats(SplatCloud& cloud, double extent) {
  constexpr std::size_t kOneOf = 1000, kAtLeast = 3;
  if (cloud.size() == 0) return 0;
  const io::SceneCore core = io::scene_core(cloud.positions);
  std::vector<std::pair<std::size_t, double>> stray;  // and the factor of its distance
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 d = glm::abs(glm::dvec3(cloud.positions[i]) - core.center);
    const double farthest = std::max({d.x, d.y, d.z});
    if (farthest > extent / 2) stray.emplace_back(i, extent / 2 / farthest);
  }
  if (stray.size() > std::max(kAtLeast, cloud.size() / kOneOf)) return 0;
  for (const auto& [i, factor] : stray) io::pull_in(cloud, i, core, factor);
  return stray.size();
}

}  // namespace fluxgs
