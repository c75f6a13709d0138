// Turns the view as the device is turned.
#pragma once

#include <optional>

#include "camera/navigation.h"

namespace fluxgs::viewer {

/// The orientation of a device in the world whose z is up (Android's game rotation vector): device
/// → world, the device's x to the right of its natural orientation, y to its top, z out of the
/// screen.
struct DevicePose {
  glm::dquat rotation{1, 0, 0, 0};
  int screen_turns = 0;  ///< quarter turns of the image (Display.getRotation()), 0…3
  double seconds = 0;
};

/// The state of following a device.
struct Gyroscope {
  struct Anchor {
    glm::dquat world{1, 0, 0, 0};   ///< the device's world → the scene's: a turn about up
    glm::dquat offset{1, 0, 0, 0};  ///< of the view, beyond the device's own turn; dies away
    double seconds = 0;             ///< when it was anchored
  };
  std::optional<Anchor> anchor;
};

/// Turns the view about the eye to where the device looks: what is up in the scene is up in the
/// world. It begins where the view is: the heading stays, pitch and roll go over to those of the
/// device within a second. Poses that are not finite are ignored.
void follow(const DevicePose& pose, Gyroscope& gyroscope, camera::Navigation& navigation);

/// After the view was turned otherwise: follows from there.
inline void anchor_anew(Gyroscope& gyroscope) { gyroscope.anchor.reset(); }

}  // namespace fluxgs::viewer
