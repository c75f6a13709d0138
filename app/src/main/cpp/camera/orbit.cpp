#include "camera/orbit.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::camera {
namespace {

/// The direction that would be the camera's right if it were upright. Along the pole there is none:
/// the camera's own right serves, and what is up in the image then decides about the turn.
glm::dvec3 level_right(const ViewState& view, const glm::dvec3& up) {
  const glm::dvec3 across = glm::cross(forward(view), up);
  const double length = glm::length(across);
  return length > 1e-6 ? across / length : right(view);
}

/// A drag in the image as (along the level, downwards), as if the camera were upright.
glm::dvec2 without_roll(const ViewState& view, const glm::dvec2& drag, const glm::dvec3& level) {
  const glm::dvec2 x(glm::dot(level, right(view)), glm::dot(level, down(view)));
  return {glm::dot(drag, x), glm::dot(drag, glm::dvec2(-x.y, x.x))};
}

/// `yaw` about up; `raise` adds to the elevation, within the limits.
glm::dquat turned(const ViewState& view, double yaw, double raise, const glm::dvec3& up,
                  const glm::dvec3& level, const TurnLimits& limits) {
  const double before = elevation(view, up);
  const double low = std::min(limits.lowest, before), high = std::max(limits.highest, before);
  const double after = std::clamp(before + raise, low, high);
  // A positive turn about the level lowers the eye
  return glm::normalize(glm::angleAxis(yaw, up) * glm::angleAxis(before - after, level) *
                        view.orientation);
}

double shorter_side(const glm::dvec2& size) { return std::max(std::min(size.x, size.y), 1.0); }

}  // namespace

double elevation(const ViewState& view, const glm::dvec3& up) {
  // Not asin, which loses half of the digits near the poles
  const glm::dvec3 back = -forward(view);
  return std::atan2(glm::dot(back, up), glm::length(glm::cross(back, up)));
}

double roll(const ViewState& view, const glm::dvec3& up) {
  const glm::dvec3 level = level_right(view, up);
  return -std::atan2(glm::dot(level, down(view)), glm::dot(level, right(view)));
}

glm::dvec3 level_direction(const ViewState& view, const glm::dvec3& up) {
  return glm::normalize(glm::cross(up, level_right(view, up)));
}

ViewState orbit(const ViewState& view, const glm::dvec2& drag, const glm::dvec2& size,
                const glm::dvec3& up, const TurnLimits& limits) {
  const glm::dvec3 level = level_right(view, up);
  const glm::dvec2 angles =
      without_roll(view, drag, level) * (std::numbers::pi / shorter_side(size));
  ViewState result = view;
  result.orientation = turned(view, -angles.x, angles.y, up, level, limits);
  return result;
}

ViewState look(const ViewState& view, const glm::dvec2& drag, const glm::dvec2& size,
               const glm::dvec3& up, const TurnLimits& limits) {
  const glm::dvec3 level = level_right(view, up);
  const glm::dvec2 angles = without_roll(view, drag, level) * units_per_pixel(view, 1, size);
  ViewState result = view;
  result.orientation = turned(view, angles.x, -angles.y, up, level, limits);
  result.target = eye(view) + view.distance * forward(result);
  return result;
}

ViewState upright(const ViewState& view, const glm::dvec3& up) {
  ViewState result = view;
  result.orientation =
      glm::normalize(glm::angleAxis(-roll(view, up), forward(view)) * view.orientation);
  return result;
}

}  // namespace fluxgs::camera
