// The view as gestures change it: a target, and the eye that looks at it.
#pragma once

#include <numbers>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/camera.h"

namespace fluxgs::camera {

// Everything in this folder is plain data and pure functions: the phone and the desktop share it.
// World: the frame of the cloud. Camera axes: x right, y down, z forward (OpenCV). Pixels: from the
// image's top left corner, y down, as fluxgs::Camera has them. Sizes of images are in pixels;
// sides below 1 count as 1. Angles are in radians, times in seconds. Finite input gives finite
// output.

inline constexpr double kDefaultFieldOfView = 50 * std::numbers::pi / 180;

/// A view with square pixels and the principal point in the image's centre, where `target` is. A
/// phone that is turned goes on showing what was in the middle.
struct ViewState {
  glm::dvec3 target{0.0};
  glm::dquat orientation{1, 0, 0, 0};  ///< camera → world, of unit length
  double distance = 1;                 ///< from the eye to the target, > 0
  double fov = kDefaultFieldOfView;    ///< of the image's shorter side, 0…π
};

/// Limits of a view's distance to its target, scene units, 0 < nearest < farthest.
struct DistanceLimits {
  double nearest = 1e-6, farthest = 1e9;
};

/// The camera's axes in the world, unit vectors.
inline glm::dvec3 right(const ViewState& v) { return v.orientation * glm::dvec3(1, 0, 0); }
inline glm::dvec3 down(const ViewState& v) { return v.orientation * glm::dvec3(0, 1, 0); }
inline glm::dvec3 forward(const ViewState& v) { return v.orientation * glm::dvec3(0, 0, 1); }
/// The centre of projection.
inline glm::dvec3 eye(const ViewState& v) { return v.target - v.distance * forward(v); }

/// World → camera of a camera that looks along `forward` with `up` upwards in the image; neither
/// need be of unit length. Where they are parallel (or one is zero) some other up is taken.
glm::dmat3 look_rotation(const glm::dvec3& forward, const glm::dvec3& up);

/// View from `eye` to `target`; see look_rotation() on `up`. Where the points coincide the distance
/// is 1e-9 and the direction +z.
ViewState view_between(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up,
                       double fov);

/// The view of a camera, with the target at this distance before it. Of the intrinsics only the
/// field of view of the shorter side is kept.
ViewState view_of(const Camera& camera, double distance);

/// The camera to render a view with. Sides below 1 count as 1.
Camera camera_of(const ViewState& view, int width, int height);

/// Scene units across a pixel, for points at this depth (along the view direction).
double units_per_pixel(const ViewState& view, double depth, const glm::dvec2& size);

/// The point at a depth that is seen in a pixel.
glm::dvec3 point_at(const ViewState& view, const glm::dvec2& pixel, double depth,
                    const glm::dvec2& size);

struct Ray {
  glm::dvec3 origin, direction;  ///< of unit length
};

/// Ray from the eye through a pixel.
Ray ray_through(const ViewState& view, const glm::dvec2& pixel, const glm::dvec2& size);

}  // namespace fluxgs::camera
