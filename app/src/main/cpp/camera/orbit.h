// Turning: around the target (orbit) and around the eye (look).
#pragma once

#include "camera/view_state.h"

namespace fluxgs::camera {

/// Limits of a view's turn up and down: the elevation of the eye over the target, −π/2…π/2, which
/// is that of the look downwards. A view that is outside already may turn back in, not further out.
/// Anything up to π/2 keeps the view from going over the pole, where left and right would swap.
struct TurnLimits {
  double lowest = -89.5 * std::numbers::pi / 180, highest = 89.5 * std::numbers::pi / 180;
};

/// The elevation of the eye over the target, for a unit vector `up`.
double elevation(const ViewState& view, const glm::dvec3& up);

/// An angle: the roll of the image, 0 where `up` points up in it, positive where the camera is
/// turned clockwise. 0 as well where the view is along `up`.
double roll(const ViewState& view, const glm::dvec3& up);

/// The direction of view without its part along `up`, of unit length; where nothing is left, a
/// level direction of the image.
glm::dvec3 level_direction(const ViewState& view, const glm::dvec3& up);

/// Turns the view about `up` (a unit vector) through the target, and up or down, by a drag in
/// pixels: the near side of the scene follows the pointer, and a drag across the image's shorter
/// side is half a turn. The roll stays what it is; a rolled view turns as its image suggests.
/// Equal and opposite drags lead back where the limits did not interfere.
ViewState orbit(const ViewState& view, const glm::dvec2& drag, const glm::dvec2& size,
                const glm::dvec3& up, const TurnLimits& limits = {});

/// The same about the eye: what is in the image's centre follows the pointer.
ViewState look(const ViewState& view, const glm::dvec2& drag, const glm::dvec2& size,
               const glm::dvec3& up, const TurnLimits& limits = {});

/// The roll undone, about the view direction.
ViewState upright(const ViewState& view, const glm::dvec3& up);

}  // namespace fluxgs::camera
