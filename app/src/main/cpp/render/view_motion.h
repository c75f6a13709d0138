// Distance between two cameras, which decides when splats are sorted again.
#pragma once

#include "sort/sorter.h"

namespace fluxgs::render {

/// Radians: the angle between the directions of view, plus the distance between the centres over
/// that from the first centre to the scene's middle. An order depends on nothing else of a camera.
/// Infinite for a camera that leaves the very middle.
double motion_between(const sort::SortView& from, const sort::SortView& to);

}  // namespace fluxgs::render
