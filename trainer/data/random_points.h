// Initial points for scenes without features.
#pragma once

#include <cstdint>

#include "trainer/data/initial_points.h"

namespace fluxgs {

/// Points that training images see: a random image, a random pixel of it, and a depth uniform
/// between 0.4 and 2 times the image's focus distance (see scene_focus.h). All are mid-grey, as in
/// 3DGS. The same for the same seed on every platform.
PointCloud random_points(const std::vector<View>& views, std::size_t count, std::uint64_t seed);

}  // namespace fluxgs
