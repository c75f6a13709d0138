// How the views of a scene see its splats, as the compact file's encoder wants to know it.
#pragma once

#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/appearance/view_weights.h"
#include "trainer/base/parallel.h"
#include "trainer/base/progress.h"
#include "trainer/model/parameters.h"

namespace fluxgs {

/// Σ α·T of each splat over all pixels of all views: the weight with which its colour enters the
/// pictures (the contribution of the paper's section on compression).
std::vector<float> total_weights(const ViewWeights& views);

/// ErrorCosts::sh_factors of a cloud with these parameters.
std::vector<float> sh_factors(const PlanarFloats& parameters, const ViewWeights& views,
                              const Threads& threads);

/// Options whose costs are those of the cameras' pictures; for networks, only the weights.
CompactOptions seen_from(const std::vector<Camera>& cameras, const SplatCloud& cloud,
                         CompactOptions options, const RenderOptions& render,
                         const Threads& threads, const ProgressReport& progress = {});

}  // namespace fluxgs
