// The view that splats are sorted for, and the distance between two of them, which decides when
// they are sorted again.
#pragma once

#include "fluxgs/camera.h"
#include "render/scene_constants.h"
#include "sort/sorter.h"

namespace fluxgs::render {

/// The view of a scene from a camera, with keys of `key_bits` bits at most.
sort::SortView sort_view(const Camera& camera, double near_plane, const SceneConstants& scene,
                         int key_bits);

/// Radians: the angle between the directions of view, plus the distance between the centres over
/// that from the first centre to the scene's middle. An order depends on nothing else of a camera.
/// Infinite for a camera that leaves the very middle.
double motion_between(const sort::SortView& from, const sort::SortView& to);

}  // namespace fluxgs::render
