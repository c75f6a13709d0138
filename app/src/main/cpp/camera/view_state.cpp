#include "camera/view_state.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::camera {
namespace {

constexpr double kSmallest = 1e-9;

glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : otherwise;
}

/// The coordinate axis that is farthest from a direction.
glm::dvec3 axis_across(const glm::dvec3& direction) {
  return std::abs(direction.y) < 0.9 ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, -1);
}

glm::dvec2 centre_of(const glm::dvec2& size) {
  return 0.5 * glm::dvec2(std::max(size.x, 1.0), std::max(size.y, 1.0));
}

}  // namespace

glm::dmat3 look_rotation(const glm::dvec3& forward, const glm::dvec3& up) {
  const glm::dvec3 z = unit_or(forward, {0, 0, 1});
  glm::dvec3 across = glm::cross(z, unit_or(up, axis_across(z)));
  if (glm::length(across) < kSmallest) across = glm::cross(z, axis_across(z));
  const glm::dvec3 x = glm::normalize(across);
  return glm::transpose(glm::dmat3(x, glm::cross(z, x), z));
}

ViewState view_between(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up,
                       double fov) {
  ViewState view;
  view.target = target;
  view.distance = std::max(glm::distance(eye, target), kSmallest);
  view.orientation =
      glm::normalize(glm::quat_cast(glm::transpose(look_rotation(target - eye, up))));
  view.fov = fov;
  return view;
}

ViewState view_of(const Camera& camera, double distance) {
  ViewState view;
  view.orientation = glm::normalize(glm::quat_cast(glm::transpose(camera.rotation)));
  view.distance = std::max(distance, kSmallest);
  view.target = camera.center() + view.distance * forward(view);
  const double slope =
      camera.width < camera.height ? camera.width / camera.fx : camera.height / camera.fy;
  view.fov = 2 * std::atan(0.5 * slope);
  return view;
}

Camera camera_of(const ViewState& view, int width, int height) {
  Camera camera;
  camera.width = std::max(width, 1);
  camera.height = std::max(height, 1);
  const int side = std::min(camera.width, camera.height);
  camera.fx = camera.fy = 0.5 * side / std::tan(0.5 * view.fov);
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  camera.rotation = glm::transpose(glm::mat3_cast(glm::normalize(view.orientation)));
  camera.translation = -(camera.rotation * eye(view));
  return camera;
}

double units_per_pixel(const ViewState& view, double depth, const glm::dvec2& size) {
  return 2 * std::tan(0.5 * view.fov) * depth / std::max(std::min(size.x, size.y), 1.0);
}

glm::dvec3 point_at(const ViewState& view, const glm::dvec2& pixel, double depth,
                    const glm::dvec2& size) {
  const glm::dvec2 offset = (pixel - centre_of(size)) * units_per_pixel(view, depth, size);
  return eye(view) + depth * forward(view) + offset.x * right(view) + offset.y * down(view);
}

Ray ray_through(const ViewState& view, const glm::dvec2& pixel, const glm::dvec2& size) {
  const glm::dvec2 slope = (pixel - centre_of(size)) * units_per_pixel(view, 1, size);
  return {eye(view), glm::normalize(forward(view) + slope.x * right(view) + slope.y * down(view))};
}

}  // namespace fluxgs::camera
