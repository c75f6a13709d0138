// Helpers of the camera tests.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "camera/view_state.h"

namespace fluxgs::camera::test {

inline constexpr double kDegree = std::numbers::pi / 180;
inline const glm::dvec2 kSize{640, 480};
inline const glm::dvec3 kUp{0, -1, 0};

/// A view from slightly above, somewhere.
inline ViewState some_view(const glm::dvec3& target = {1, 2, 3}) {
  return view_between(target + glm::dvec3(2, -1.5, -4), target, kUp, 50 * kDegree);
}

/// Where a point lands, pixels.
inline glm::dvec2 pixel_of(const ViewState& view, const glm::dvec3& point,
                           const glm::dvec2& size = kSize) {
  const Camera c = camera_of(view, static_cast<int>(size.x), static_cast<int>(size.y));
  const glm::dvec3 p = c.rotation * (point - c.center());
  return {c.fx * p.x / p.z + c.cx, c.fy * p.y / p.z + c.cy};
}

/// The angle between the directions of two views and their images' tops.
inline double turn_between(const ViewState& a, const ViewState& b) {
  const double cosine = std::min(1.0, std::abs(glm::dot(a.orientation, b.orientation)));
  return 2 * std::acos(cosine);
}

inline bool is_finite(const ViewState& v) {
  return std::isfinite(glm::dot(v.target, v.target)) && std::isfinite(v.distance) &&
         v.distance > 0 && std::abs(glm::length(v.orientation) - 1) < 1e-9 && std::isfinite(v.fov);
}

/// The same image, but for `tolerance` scene units and about as many radians.
inline void expect_same_view(const ViewState& a, const ViewState& b, double tolerance = 1e-9) {
  EXPECT_LT(glm::distance(eye(a), eye(b)), tolerance);
  EXPECT_LT(glm::distance(a.target, b.target), tolerance);
  EXPECT_LT(glm::distance(right(a), right(b)), tolerance);
  EXPECT_LT(glm::distance(down(a), down(b)), tolerance);
}

}  // namespace fluxgs::camera::test
