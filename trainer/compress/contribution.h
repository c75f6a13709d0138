// How much of the pictures each splat makes up.
#pragma once

#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/base/parallel.h"
#include "trainer/base/progress.h"

namespace fluxgs {

/// Σ α·T of each splat over all pixels of all views, in the order of the cloud: the weight with
/// which its colour enters the pictures (the contribution of the paper's section on compression).
std::vector<float> splat_contributions(const SplatCloud& cloud, const std::vector<Camera>& cameras,
                                       const RenderOptions& options, const Threads& threads,
                                       const ProgressReport& progress = {});

}  // namespace fluxgs
