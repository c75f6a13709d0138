#include "camera/pan_zoom.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::camera {

ViewState pan(const ViewState& view, const glm::dvec2& drag, const glm::dvec2& size) {
  const glm::dvec2 move = drag * units_per_pixel(view, view.distance, size);
  ViewState result = view;
  result.target -= move.x * right(view) + move.y * down(view);
  return result;
}

ViewState zoom(const ViewState& view, double factor, const glm::dvec2& pixel,
               const glm::dvec2& size, const DistanceLimits& limits) {
  if (!(factor > 0) || !std::isfinite(factor)) return view;
  const double nearest = std::min(limits.nearest, view.distance);
  const double farthest = std::max(limits.farthest, view.distance);
  ViewState result = view;
  result.distance = std::clamp(view.distance / factor, nearest, farthest);
  // Shrinking everything towards a point leaves the directions from it as they are
  const glm::dvec3 anchor = point_at(view, pixel, view.distance, size);
  result.target = anchor + (view.target - anchor) * (result.distance / view.distance);
  return result;
}

ViewState twist(const ViewState& view, double angle, const glm::dvec2& pixel,
                const glm::dvec2& size) {
  const glm::dvec3 anchor = point_at(view, pixel, view.distance, size);
  const glm::dquat turn = glm::angleAxis(-angle, forward(view));
  ViewState result = view;
  result.orientation = glm::normalize(turn * view.orientation);
  result.target = anchor + turn * (view.target - anchor);
  return result;
}

ViewState pinch(const ViewState& view, const TwoFingers& before, const TwoFingers& now,
                const glm::dvec2& size, const DistanceLimits& limits, Twist twisting) {
  const glm::dvec2 was = before.second - before.first, is = now.second - now.first;
  const glm::dvec2 from = 0.5 * (before.first + before.second);
  const glm::dvec2 to = 0.5 * (now.first + now.second);
  ViewState result = view;
  if (glm::length(was) >= 1 && glm::length(is) >= 1) {
    result = zoom(result, glm::length(is) / glm::length(was), from, size, limits);
    if (twisting == Twist::rolls) {
      const double angle = std::atan2(was.x * is.y - was.y * is.x, glm::dot(was, is));
      result = twist(result, angle, from, size);
    }
  }
  return pan(result, to - from, size);
}

}  // namespace fluxgs::camera
