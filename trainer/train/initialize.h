// The first splats of a scene.
#pragma once

#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/data/initial_points.h"

namespace fluxgs {

/// One round splat per point: its deviation is the root mean square distance to its three nearest
/// neighbours (3DGS), its constant colour that of the point.
SplatCloud splats_from_points(const PointCloud& points, double opacity, const Threads& threads);

}  // namespace fluxgs
