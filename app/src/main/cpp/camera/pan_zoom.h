// Moving along the image and towards a point of it: one pointer, a wheel, two fingers.
#pragma once

#include "camera/view_state.h"

namespace fluxgs::camera {

/// Moves the camera along its image: what is at the target's depth follows a drag in pixels.
ViewState pan(const ViewState& view, const glm::dvec2& drag, const glm::dvec2& size);

/// Divides the distance to the target by `factor` (> 1: nearer), within the limits. The point at
/// the target's depth that is seen in `pixel` stays there. A view outside the limits may come back,
/// not go further out. Factors that are not positive numbers change nothing.
ViewState zoom(const ViewState& view, double factor, const glm::dvec2& pixel,
               const glm::dvec2& size, const DistanceLimits& limits = {});

/// Turns the camera about the view direction through the point at the target's depth in `pixel`;
/// the image turns clockwise by `angle` about that pixel.
ViewState twist(const ViewState& view, double angle, const glm::dvec2& pixel,
                const glm::dvec2& size);

/// Positions of two fingers, pixels.
struct TwoFingers {
  glm::dvec2 first, second;
};

enum class Twist { ignored, rolls };

/// Pan, zoom and twist from how two fingers moved: the points of the scene at the target's depth
/// that were under them still are (with Twist::ignored, or where the limits interfere: the point
/// midway). Fingers nearer than a pixel to each other only pan.
ViewState pinch(const ViewState& view, const TwoFingers& before, const TwoFingers& now,
                const glm::dvec2& size, const DistanceLimits& limits = {},
                Twist twisting = Twist::rolls);

}  // namespace fluxgs::camera
