#include "tools/fluxgs/orbit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "trainer/data/scene_focus.h"

namespace fluxgs::cli {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInset = 0.05;

double percentile(std::vector<double> values, double fraction) {
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

/// Where an orbit goes. Angles are in radians, from `front` towards `side`.
struct Circle {
  glm::dvec3 center{0}, up{0, -1, 0};
  glm::dvec3 front{0}, side{0};  // with `up` a basis of unit vectors
  double radius = 1, height = 0, fov_y = 50 * kPi / 180;
  double begin = 0, span = 2 * kPi;

  /// Any two directions across `up`; angle 0 is as near as can be to before the scene's z axis.
  void set_up(const glm::dvec3& direction) {
    up = direction;
    const glm::dvec3 guess = std::abs(up.z) < 0.9 ? glm::dvec3(0, 0, -1) : glm::dvec3(-1, 0, 0);
    side = glm::normalize(glm::cross(up, guess));
    front = glm::cross(side, up);
  }
  double angle_of(const glm::dvec3& eye) const {
    const glm::dvec3 arm = eye - center;
    return std::atan2(glm::dot(arm, side), glm::dot(arm, front));
  }
  glm::dvec3 eye_at(double angle) const {
    return center + radius * (std::cos(angle) * front + std::sin(angle) * side) + height * up;
  }
};

/// Leaves out the widest gap between the photos if it is wider than a quarter of the circle.
void limit_to_covered_arc(Circle& c, const std::vector<Photo>& photos) {
  std::vector<double> angles;
  for (const Photo& photo : photos) angles.push_back(c.angle_of(photo.camera.center()));
  std::ranges::sort(angles);
  double widest = 2 * kPi - (angles.back() - angles.front()), after = angles.front();
  for (std::size_t i = 1; i < angles.size(); ++i)
    if (angles[i] - angles[i - 1] > widest) widest = angles[i] - angles[i - 1], after = angles[i];
  if (widest <= kPi / 2) return;
  // The outermost photos show their places from one side only
  const double covered = 2 * kPi - widest;
  c.begin = after + kInset * covered;
  c.span = (1 - 2 * kInset) * covered;
}

Circle circle_along(const std::vector<Photo>& photos) {
  Circle c;
  const std::vector<double> distances = focus_distances(photos);
  const double share = 1.0 / static_cast<double>(photos.size());
  glm::dvec3 up(0), eyes(0);
  c.fov_y = 0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Camera& camera = photos[i].camera;
    c.center += share * (camera.center() + distances[i] * camera.forward());
    up -= share * glm::dvec3(camera.rotation[0][1], camera.rotation[1][1], camera.rotation[2][1]);
    c.fov_y += share * 2 * std::atan(0.5 * camera.height / camera.fy);
    eyes += share * camera.center();
  }
  c.set_up(glm::length(up) > 1e-9 ? glm::normalize(up) : glm::dvec3(0, -1, 0));
  c.height = glm::dot(eyes - c.center, c.up);
  c.radius = 0;
  for (const Photo& photo : photos) {
    const glm::dvec3 arm = photo.camera.center() - c.center;
    c.radius += share * glm::length(arm - c.up * glm::dot(arm, c.up));
  }
  c.radius = std::max(c.radius, 1e-6);  // photos of a panorama, from one place
  limit_to_covered_arc(c, photos);
  return c;
}

Circle circle_around(const SplatCloud& cloud) {
  Circle c;
  c.set_up({0, -1, 0});
  if (cloud.size() == 0) return c;
  std::vector<double> values(cloud.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < cloud.size(); ++i)
      values[i] = static_cast<double>(cloud.positions[i][axis]);
    // The middle of the extent, not the median: detail draws that to where splats are small
    c.center[axis] = 0.5 * (percentile(values, 0.02) + percentile(values, 0.98));
  }
  for (std::size_t i = 0; i < cloud.size(); ++i)
    values[i] = glm::distance(glm::dvec3(cloud.positions[i]), c.center);
  const double size = std::max(percentile(values, 0.9), 1e-6);  // far floaters do not count
  const double distance = 1.15 * size / std::sin(0.5 * c.fov_y);
  c.height = 0.3 * distance;
  c.radius = std::sqrt(distance * distance - c.height * c.height);
  return c;
}

std::vector<Camera> cameras_on(const Circle& c, int count, const PictureSize& size) {
  const bool closed = c.span >= 2 * kPi;
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    double part = 0.5;  // of an arc with a single camera
    if (closed)
      part = static_cast<double>(i) / count;
    else if (count > 1)
      part = static_cast<double>(i) / (count - 1);
    cameras.push_back(look_at(c.eye_at(c.begin + part * c.span), c.center, c.up, c.fov_y, size));
    cameras.back().name = fmt::format("{:03}", i);
  }
  return cameras;
}

}  // namespace

std::vector<Camera> orbit_along(const std::vector<Photo>& photos, int count,
                                const PictureSize& size) {
  return cameras_on(circle_along(photos), count, size);
}

std::vector<Camera> orbit_around(const SplatCloud& cloud, int count, const PictureSize& size) {
  return cameras_on(circle_around(cloud), count, size);
}

}  // namespace fluxgs::cli
