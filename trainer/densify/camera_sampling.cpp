#include "trainer/densify/camera_sampling.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <glm/geometric.hpp>

#include "trainer/core/indices.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs {
namespace {

glm::dvec3 scene_center(const std::vector<View>& views) {
  const std::vector<Ray> rays = view_rays(cameras_of(views));
  if (const auto nearest = nearest_point_to_rays(rays)) return *nearest;
  const std::vector<double> distances = focus_distances(views);
  glm::dvec3 mean(0);
  for (std::size_t i = 0; i < rays.size(); ++i)
    mean += (rays[i].origin + rays[i].direction * distances[i]) / static_cast<double>(rays.size());
  return mean;
}

int bin_of(double angle, double range, int bins) {
  return std::clamp(static_cast<int>(std::floor(angle / range * bins)), 0, bins - 1);
}

}  // namespace

std::vector<std::vector<std::uint32_t>> camera_bins(const std::vector<View>& views, int azimuth,
                                                    int elevation) {
  constexpr double kPi = std::numbers::pi;
  const glm::dvec3 center = scene_center(views);
  std::map<std::pair<int, int>, std::vector<std::uint32_t>> bins;
  for (std::uint32_t i = 0; i < views.size(); ++i) {
    const glm::dvec3 r = views[i].camera.center() - center;
    const double distance = glm::length(r);
    const double sine = distance > 0 ? std::clamp(r.z / distance, -1.0, 1.0) : 0.0;
    bins[{bin_of(std::atan2(r.y, r.x) + kPi, 2 * kPi, azimuth),
          bin_of(std::asin(sine) + kPi / 2, kPi, elevation)}]
        .push_back(i);
  }
  std::vector<std::vector<std::uint32_t>> filled;
  for (auto& [place, members] : bins) filled.push_back(std::move(members));
  return filled;
}

std::vector<std::uint32_t> sample_cameras(const std::vector<View>& views,
                                          const ScoreOptions& options, Random& random) {
  const std::size_t count =
      std::min<std::size_t>(static_cast<std::size_t>(options.views), views.size());
  std::vector<std::uint32_t> chosen;
  if (options.sampling == CameraSampling::random) {
    chosen = all_indices(views.size());
    shuffle(chosen, random);
  } else {
    auto bins = camera_bins(views, options.azimuth_bins, options.elevation_bins);
    for (auto& members : bins) shuffle(members, random);
    while (chosen.size() < count) {
      std::vector<std::uint32_t> order = all_indices(bins.size());
      shuffle(order, random);
      for (std::uint32_t b : order) {
        if (bins[b].empty()) continue;
        chosen.push_back(bins[b].back());
        bins[b].pop_back();
      }
    }
  }
  chosen.resize(count);
  return chosen;
}

}  // namespace fluxgs
