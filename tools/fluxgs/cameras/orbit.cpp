#include "tools/fluxgs/cameras/orbit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "camera/initial_view.h"
#include "camera/scene_fit.h"
#include "camera/up_axis.h"
#include "trainer/compress/scene_error.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs::cli {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInset = 0.05;

/// Path of an orbit. Angles are in radians, from `front` towards `side`.
struct Circle {
  glm::dvec3 center{0}, up{0, -1, 0};
  glm::dvec3 front{0}, side{0};  // with `up` a basis of unit vectors
  double radius = 1, height = 0, fov_y = camera::kDefaultFieldOfView;
  double begin = 0, span = 2 * kPi;

  void set_up(const glm::dvec3& direction) {
    up = direction;
    front = camera::level_front(up);
    side = glm::cross(up, front);
  }
  double angle_of(const glm::dvec3& eye) const {
    const glm::dvec3 arm = eye - center;
    return std::atan2(glm::dot(arm, side), glm::dot(arm, front));
  }
  glm::dvec3 eye_at(double angle) const {
    return center + radius * (std::cos(angle) * front + std::sin(angle) * side) + height * up;
  }
};

/// Leaves out the widest gap between the images if it is wider than a quarter of the circle.
void limit_to_covered_arc(Circle& c, const std::vector<View>& views) {
  std::vector<double> angles;
  for (const View& view : views) angles.push_back(c.angle_of(view.camera.center()));
  std::ranges::sort(angles);
  double widest = 2 * kPi - (angles.back() - angles.front()), after = angles.front();
  for (std::size_t i = 1; i < angles.size(); ++i)
    if (angles[i] - angles[i - 1] > widest) widest = angles[i] - angles[i - 1], after = angles[i];
  if (widest <= kPi / 2) return;
  // The outermost images show their places from one side only
  const double covered = 2 * kPi - widest;
  c.begin = after + kInset * covered;
  c.span = (1 - 2 * kInset) * covered;
}

Circle circle_along(const std::vector<View>& views) {
  Circle c;
  const std::vector<double> distances = focus_distances(views);
  const double share = 1.0 / static_cast<double>(views.size());
  glm::dvec3 eyes(0);
  std::vector<Camera> cameras;
  c.fov_y = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = cameras.emplace_back(views[i].camera);
    c.center += share * (camera.center() + distances[i] * camera.forward());
    c.fov_y += share * 2 * std::atan(0.5 * camera.height / camera.fy);
    eyes += share * camera.center();
  }
  c.set_up(camera::up_of_cameras(cameras).direction);
  c.height = glm::dot(eyes - c.center, c.up);
  c.radius = 0;
  for (const View& view : views) {
    const glm::dvec3 arm = view.camera.center() - c.center;
    c.radius += share * glm::length(arm - c.up * glm::dot(arm, c.up));
  }
  c.radius = std::max(c.radius, 1e-6);  // images of a panorama, from one place
  limit_to_covered_arc(c, views);
  return c;
}

/// `height`: of the eye above the middle, as a part of the distance.
Circle circle_around(const SplatCloud& cloud, const ImageSize& size,
                     double height = camera::kInitialHeight) {
  // Sizes of compact scenes are measured over these views: they stay what they are
  const camera::SceneBounds bounds = camera::robust_bounds(cloud, camera::SplatWeight::equal);
  Circle c;
  c.set_up(camera::kDefaultUp);
  c.center = bounds.center;
  const double across = std::min(1.0, static_cast<double>(size.width) / size.height);
  const double shorter = 2 * std::atan(across * std::tan(0.5 * c.fov_y));
  const double distance = camera::fitting_distance(bounds.radius, shorter);
  c.height = height * distance;
  c.radius = std::sqrt(distance * distance - c.height * c.height);
  return c;
}

Circle circle_through(const camera::Navigation& start) {
  // From right above there is no way around
  constexpr double kLevel = 0.2;  // of the distance
  Circle c;
  c.set_up(start.up);
  c.center = start.view.target;
  c.fov_y = start.view.fov;
  const glm::dvec3 arm = camera::eye(start.view) - c.center;
  c.height = glm::dot(arm, c.up);
  c.radius = std::max(glm::length(arm - c.up * c.height), kLevel * glm::length(arm));
  c.begin = c.angle_of(camera::eye(start.view));
  return c;
}

std::vector<Camera> cameras_on(const Circle& c, int count, const ImageSize& size) {
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

std::vector<Camera> orbit_along(const std::vector<View>& views, int count, const ImageSize& size) {
  return cameras_on(circle_along(views), count, size);
}

std::vector<Camera> orbit_around(const SplatCloud& cloud, int count, const ImageSize& size) {
  return cameras_on(circle_around(cloud, size), count, size);
}

std::vector<Camera> orbit_through(const camera::Navigation& start, int count,
                                  const ImageSize& size) {
  return cameras_on(circle_through(start), count, size);
}

ImageSize reduction_size(std::size_t splats) {
  constexpr double kMostSplats = 30000;  // from so many on images are of full size
  constexpr int kWidth = 640, kLeast = 160;
  const double factor = std::sqrt(std::min(1.0, static_cast<double>(splats) / kMostSplats));
  const int width = std::max(kLeast, static_cast<int>(std::lround(factor * kWidth)));
  return {width, width * 3 / 4};
}

std::vector<Camera> evaluation_cameras(const SplatCloud& cloud, const Dataset* data) {
  if (data == nullptr) return orbit_around(cloud, kEvaluationCameras, {640, 480});
  return spread_cameras(cameras_of(data->train), kEvaluationCameras);
}

std::vector<Camera> reduction_cameras(const SplatCloud& cloud,
                                      const std::optional<InitialView>& start,
                                      const Dataset* data) {
  constexpr std::size_t kMost = 48;
  constexpr int kAround = 12;
  constexpr double kHeights[] = {0.1, -0.2, 0.7};
  const ImageSize size = reduction_size(cloud.size());
  std::vector<Camera> cameras;
  if (data != nullptr) {
    for (const Camera& camera : spread_cameras(cameras_of(data->train), kMost)) {
      const double factor =
          std::min(1.0, double(size.width) / std::max(camera.width, camera.height));
      const auto side = [&](int pixels) {
        return std::max(1, static_cast<int>(std::lround(factor * pixels)));
      };
      cameras.push_back(resized(camera, {side(camera.width), side(camera.height)}));
    }
    return cameras;
  }
  for (const double height : kHeights)
    std::ranges::copy(cameras_on(circle_around(cloud, size, height), kAround, size),
                      std::back_inserter(cameras));
  if (start)
    std::ranges::copy(
        orbit_through(camera::initial_navigation(cloud, start, {size.width, size.height}), kAround,
                      size),
        std::back_inserter(cameras));
  return cameras;
}

}  // namespace fluxgs::cli
