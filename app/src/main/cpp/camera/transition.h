// Smooth transition between two views.
#pragma once

#include "camera/view_state.h"

namespace fluxgs::camera {

/// The view at a part (0…1, clamped) of the way: starts and ends at rest, turns the shorter way
/// round, and changes the distance by equal factors in equal times.
ViewState between(const ViewState& from, const ViewState& to, double part);

struct Transition {
  ViewState from, to;
  double seconds = 0.35;  ///< the whole way; 0 or less: at once
  double elapsed = 0;
};

bool finished(const Transition& transition);

/// Lets time pass; the view after it, which is `to` exactly once finished.
ViewState advance(Transition& transition, double seconds);

}  // namespace fluxgs::camera
