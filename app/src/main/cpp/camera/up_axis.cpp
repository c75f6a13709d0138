#include "camera/up_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Eigenvalues>
#include <glm/geometric.hpp>

#include "camera/sample.h"
#include "camera/scene_fit.h"

namespace fluxgs::camera {
namespace {

constexpr double kLikeADisc = 0.45;

/// Directions with the part of the whole that lies along each, ascending.
struct PrincipalAxes {
  std::array<glm::dvec3, 3> directions;
  std::array<double, 3> parts{};
};

/// Axes of a symmetric matrix without negative eigenvalues; nothing for a zero one.
std::optional<PrincipalAxes> principal_axes(const Eigen::Matrix3d& matrix) {
  const double trace = matrix.trace();
  if (!(trace > 0) || !std::isfinite(trace)) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix / trace);
  PrincipalAxes axes;
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const Eigen::Vector3d v = solver.eigenvectors().col(k);
    axes.directions[at] = glm::dvec3(v[0], v[1], v[2]);
    axes.parts[at] = std::max(solver.eigenvalues()[k], 0.0);
  }
  return axes;
}

void add_outer_product(const glm::dvec3& v, double weight, Eigen::Matrix3d& sum) {
  const Eigen::Vector3d e(v.x, v.y, v.z);
  sum += weight * e * e.transpose();
}

glm::dvec3 row(const Camera& camera, int i) {
  return {camera.rotation[0][i], camera.rotation[1][i], camera.rotation[2][i]};
}

struct WeightedPoint {
  glm::dvec3 position;
  double weight;
};

/// The middle of a scene: positions with opacity times area.
std::vector<WeightedPoint> weighted_points(const SplatCloud& cloud) {
  const SceneBounds bounds = robust_bounds(cloud);
  std::vector<WeightedPoint> points;
  std::vector<Weighted> areas;
  for (const std::size_t i : even_sample(cloud)) {
    const glm::dvec3 position = glm::dvec3(cloud.positions[i]) - bounds.center;
    if (glm::length(position) > bounds.radius) continue;
    const glm::dvec3 s(cloud.log_scales[i]);
    const double area = std::exp(s.x + s.y + s.z - std::min({s.x, s.y, s.z}));
    points.push_back({position, area});
    areas.emplace_back(area, opacity_of(cloud, i));
  }
  if (points.empty()) return points;
  std::vector<Weighted> sorted = areas;
  const double largest = quantile(sorted, 0.95);  // skies and walls of one splat do not decide
  for (std::size_t k = 0; k < points.size(); ++k)
    points[k].weight = areas[k].second * std::min(points[k].weight, largest);
  return points;
}

glm::dvec3 mean_of(const std::vector<WeightedPoint>& points) {
  glm::dvec3 sum(0);
  double weight = 0;
  for (const WeightedPoint& p : points) sum += p.weight * p.position, weight += p.weight;
  return weight > 0 ? sum / weight : sum;
}

/// Positive where the thinner tail lies along the axis.
double skewness(const std::vector<WeightedPoint>& points, const glm::dvec3& mean,
                const glm::dvec3& axis) {
  double weight = 0, second = 0, third = 0;
  for (const WeightedPoint& p : points) {
    const double h = glm::dot(p.position - mean, axis);
    weight += p.weight;
    second += p.weight * h * h;
    third += p.weight * h * h * h;
  }
  if (!(weight > 0) || !(second > 0)) return 0;
  return third / weight / std::pow(second / weight, 1.5);
}

/// −1…1: how much convention has an axis point up. COLMAP's y is down; frames without it have z up.
double conventional(const glm::dvec3& axis) {
  return std::abs(axis.y) > 0.25 ? std::clamp(-2 * axis.y, -1.0, 1.0) : axis.z;
}

}  // namespace

UpAxis up_of_cameras(std::span<const Camera> cameras) {
  Eigen::Matrix3d rights = Eigen::Matrix3d::Zero();
  glm::dvec3 ups(0);
  for (const Camera& camera : cameras) {
    add_outer_product(row(camera, 0), 1, rights);
    ups -= row(camera, 1);
  }
  const auto axes = principal_axes(rights);
  if (!axes) return {};
  constexpr double kRightsDecide = 0.05;
  const glm::dvec3& widest = axes->directions[2];
  glm::dvec3 up =
      axes->parts[1] > kRightsDecide ? axes->directions[0] : ups - widest * glm::dot(ups, widest);
  if (glm::length(up) < 1e-9) return {};
  up = glm::normalize(glm::dot(up, ups) < 0 ? -up : up);
  const double agreement = glm::dot(up, ups) / static_cast<double>(cameras.size());
  return {up, std::clamp(agreement, 0.0, 1.0)};
}

UpAxis up_of_cloud(const SplatCloud& cloud) {
  const std::vector<WeightedPoint> points = weighted_points(cloud);
  const glm::dvec3 mean = mean_of(points);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const WeightedPoint& p : points) add_outer_product(p.position - mean, p.weight, spread);
  const auto axes = principal_axes(spread);
  if (!axes || !(axes->parts[1] > 0)) return {};
  const auto& [thin, middle, wide] = axes->parts;
  const double like_a_disc = (1 - thin / middle) * (middle / wide);
  if (like_a_disc < kLikeADisc) return {};
  const glm::dvec3& axis = axes->directions[0];
  const double side = skewness(points, mean, axis) + conventional(axis);
  return {side < 0 ? -axis : axis, like_a_disc * std::min(std::abs(side), 1.0)};
}

}  // namespace fluxgs::camera
