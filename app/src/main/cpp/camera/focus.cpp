#include "camera/focus.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "camera/sample.h"

namespace fluxgs::camera {
namespace {

constexpr double kReach = 3;        // standard deviations
constexpr double kAlphaMax = 0.99;  // that of RenderOptions
constexpr double kNextToNothing = 0.05;
constexpr double kPixelsAround = 2;

struct Hit {
  double distance, alpha;
};

/// The point of a ray at which a splat is densest, and its α there; nothing if that is far from it.
std::optional<Hit> hit(const SplatCloud& cloud, std::size_t i, const Ray& ray, double spread,
                       double nearest) {
  const glm::dvec3 arm = glm::dvec3(cloud.positions[i]) - ray.origin;
  const double along = glm::dot(arm, ray.direction);
  if (!(along > nearest)) return std::nullopt;
  const glm::dvec3 log_scales(cloud.log_scales[i]);
  const double largest = std::exp(std::max({log_scales.x, log_scales.y, log_scales.z}));
  const double blur = spread * along, reach = kReach * (largest + blur);
  if (!(glm::dot(arm, arm) - along * along < reach * reach)) return std::nullopt;
  // In the splat's own axes, in units of its deviations: the nearest point of a line to the origin
  glm::dquat rotation(cloud.rotations[i]);
  rotation = glm::dot(rotation, rotation) > 0 ? glm::conjugate(glm::normalize(rotation))
                                              : glm::dquat(1, 0, 0, 0);
  const glm::dvec3 deviations = glm::sqrt(glm::exp(2.0 * log_scales) + blur * blur);
  const glm::dvec3 from = (rotation * -arm) / deviations;
  const glm::dvec3 way = (rotation * ray.direction) / deviations;
  const double distance = -glm::dot(from, way) / glm::dot(way, way);
  const glm::dvec3 closest = from + distance * way;
  const double alpha = opacity_of(cloud, i) * std::exp(-0.5 * glm::dot(closest, closest));
  if (!(distance > nearest) || !std::isfinite(alpha)) return std::nullopt;
  return Hit{distance, std::min(alpha, kAlphaMax)};
}

}  // namespace

std::optional<double> visible_distance(const SplatCloud& cloud, const Ray& ray, double spread,
                                       double nearest) {
  std::vector<Hit> hits;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (const auto found = hit(cloud, i, ray, spread, nearest)) hits.push_back(*found);
  std::ranges::sort(hits, {}, &Hit::distance);
  double passing = 1;
  for (const Hit& h : hits) passing *= 1 - h.alpha;
  const double half = 0.5 * (1 - passing);
  if (half < 0.5 * kNextToNothing) return std::nullopt;
  passing = 1;
  for (const Hit& h : hits) {
    passing *= 1 - h.alpha;
    if (1 - passing >= half) return h.distance;
  }
  return hits.back().distance;
}

std::optional<glm::dvec3> visible_point(const SplatCloud& cloud, const ViewState& view,
                                        const glm::dvec2& pixel, const glm::dvec2& size,
                                        double nearest) {
  const Ray ray = ray_through(view, pixel, size);
  const double spread = kPixelsAround * units_per_pixel(view, 1, size);
  const auto distance = visible_distance(cloud, ray, spread, nearest);
  if (!distance) return std::nullopt;
  return ray.origin + *distance * ray.direction;
}

ViewState focused_on(const ViewState& view, const glm::dvec3& point, const DistanceLimits& limits,
                     double closer) {
  const double depth = glm::dot(point - eye(view), forward(view));
  ViewState result = view;
  result.target = point;
  result.distance =
      std::clamp(closer * (depth > 0 ? depth : view.distance), limits.nearest, limits.farthest);
  return result;
}

}  // namespace fluxgs::camera
