#include "viewer/gyroscope.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace fluxgs::viewer {
namespace {

constexpr double kFade = 0.25;  // seconds in which the offset falls to 1/e

/// The turn that takes one unit vector to another.
glm::dquat turn_between(const glm::dvec3& from, const glm::dvec3& to) {
  const double cosine = glm::dot(from, to);
  if (cosine < -0.999999) {  // any axis across
    const glm::dvec3 across = std::abs(from.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 axis = glm::normalize(glm::cross(from, across));
    return glm::dquat(0, axis.x, axis.y, axis.z);
  }
  const glm::dvec3 axis = glm::cross(from, to);
  return glm::normalize(glm::dquat(1 + cosine, axis.x, axis.y, axis.z));
}

/// Camera → the device's world. The camera looks out of the device's back; its axes are x right and
/// y down in the image as it is shown.
glm::dquat camera_of(const DevicePose& pose) {
  const glm::dquat half_turn_about_x(0, 1, 0, 0);
  const double angle = pose.screen_turns * std::numbers::pi / 2;
  const glm::dquat screen = glm::angleAxis(-angle, glm::dvec3(0, 0, 1));
  return glm::normalize(pose.rotation) * screen * half_turn_about_x;
}

/// The angle about `up` by which one direction is turned from another; 0 where one is along `up`.
double heading_between(const glm::dvec3& from, const glm::dvec3& to, const glm::dvec3& up) {
  const glm::dvec3 a = from - glm::dot(from, up) * up, b = to - glm::dot(to, up) * up;
  if (glm::length(a) < 1e-6 || glm::length(b) < 1e-6) return 0;
  return std::atan2(glm::dot(glm::cross(a, b), up), glm::dot(a, b));
}

/// The direction that a camera faces; where it looks up or down, that of its image's up or down.
glm::dvec3 facing(const glm::dquat& camera, const glm::dvec3& up) {
  const glm::dvec3 forward = camera * glm::dvec3(0, 0, 1);
  const double pitch = glm::dot(forward, up);
  if (std::abs(pitch) < 0.95) return forward;
  return camera * glm::dvec3(0, pitch > 0 ? 1 : -1, 0);
}

Gyroscope::Anchor anchored(const glm::dquat& device, const DevicePose& pose,
                           const camera::Navigation& n) {
  const glm::dquat upright = turn_between({0, 0, 1}, n.up);
  const double heading =
      heading_between(facing(upright * device, n.up), facing(n.view.orientation, n.up), n.up);
  const glm::dquat world = glm::angleAxis(heading, n.up) * upright;
  const glm::dquat offset = n.view.orientation * glm::inverse(world * device);
  return {.world = world, .offset = glm::normalize(offset), .seconds = pose.seconds};
}

bool is_sound(const glm::dquat& q) {
  const double length = glm::length(q);
  return std::isfinite(length) && length > 1e-6;
}

}  // namespace

void follow(const DevicePose& pose, Gyroscope& gyroscope, camera::Navigation& n) {
  if (!is_sound(pose.rotation) || !std::isfinite(pose.seconds)) return;
  const glm::dquat device = camera_of(pose);
  if (!gyroscope.anchor) gyroscope.anchor = anchored(device, pose, n);
  const Gyroscope::Anchor& anchor = *gyroscope.anchor;
  const double left = std::exp(-std::max(pose.seconds - anchor.seconds, 0.0) / kFade);
  const glm::dquat offset = glm::slerp(glm::dquat(1, 0, 0, 0), anchor.offset, left);
  const glm::dvec3 eye = camera::eye(n.view);
  n.view.orientation = glm::normalize(offset * anchor.world * device);
  n.view.target = eye + n.view.distance * camera::forward(n.view);
}

}  // namespace fluxgs::viewer
