#include "camera/scene_fit.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "camera/sample.h"

namespace fluxgs::camera {
namespace {

constexpr double kLow = 0.02, kHigh = 0.98, kWithin = 0.9;
constexpr double kMargin = 1.15;

double largest_deviation(const SplatCloud& cloud, std::size_t i) {
  const glm::vec3& s = cloud.log_scales[i];
  return std::exp(static_cast<double>(std::max({s.x, s.y, s.z})));
}

}  // namespace

double quantile(std::vector<Weighted>& values, double part) {
  std::ranges::sort(values);
  double total = 0;
  for (const Weighted& v : values) total += v.second;
  const bool unweighted = !(total > 0);
  if (unweighted) total = static_cast<double>(values.size());
  double below = 0;
  for (const auto& [value, weight] : values) {
    below += unweighted ? 1 : weight;
    if (below >= part * total) return value;
  }
  return values.back().first;
}

SceneBounds robust_bounds(const SplatCloud& cloud, SplatWeight weight) {
  const std::vector<std::size_t> sample = even_sample(cloud);
  SceneBounds bounds;
  if (sample.empty()) return bounds;
  std::vector<Weighted> values(sample.size());
  std::vector<double> weights(sample.size(), 1.0);
  if (weight == SplatWeight::opacity)
    std::ranges::transform(sample, weights.begin(),
                           [&](std::size_t i) { return opacity_of(cloud, i); });
  const auto fill = [&](auto&& value_of) {
    for (std::size_t k = 0; k < sample.size(); ++k) values[k] = {value_of(sample[k]), weights[k]};
  };
  for (int axis = 0; axis < 3; ++axis) {
    fill([&](std::size_t i) { return static_cast<double>(cloud.positions[i][axis]); });
    bounds.low[axis] = quantile(values, kLow);
    bounds.high[axis] = quantile(values, kHigh);
  }
  // The middle of the extent, not the median: detail draws that to where splats are small
  bounds.center = 0.5 * (bounds.low + bounds.high);
  fill([&](std::size_t i) { return glm::distance(glm::dvec3(cloud.positions[i]), bounds.center); });
  bounds.radius = quantile(values, kWithin);
  fill([&](std::size_t i) { return 3 * largest_deviation(cloud, i); });
  const double smallest = 1e-6 * (1 + glm::length(bounds.center));
  bounds.radius = std::max({bounds.radius, quantile(values, 0.5), smallest});
  return bounds;
}

SceneUnits units_of(const SceneBounds& bounds) {
  const double r = bounds.radius;
  return {.near_plane = 0.002 * r,
          .speed = 0.4 * r,
          .distances = {.nearest = 0.002 * r, .farthest = 50 * r},
          .center = bounds.center,
          .radius = r};
}

glm::dvec3 level_front(const glm::dvec3& up) {
  const glm::dvec3 guess = std::abs(up.z) < 0.9 ? glm::dvec3(0, 0, -1) : glm::dvec3(-1, 0, 0);
  return glm::cross(glm::normalize(glm::cross(up, guess)), up);
}

double fitting_distance(double radius, double fov) {
  return kMargin * radius / std::sin(0.5 * fov);
}

ViewState fitting_view(const SceneBounds& bounds, const glm::dvec3& up, double fov) {
  const double distance = fitting_distance(bounds.radius, fov);
  const double level = std::sqrt(1 - kInitialHeight * kInitialHeight);
  const glm::dvec3 arm = distance * (level * level_front(up) + kInitialHeight * up);
  return view_between(bounds.center + arm, bounds.center, up, fov);
}

}  // namespace fluxgs::camera
