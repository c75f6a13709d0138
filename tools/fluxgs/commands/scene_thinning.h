// Fewer splats for a smaller or faster scene: those that add least go.
#pragma once

#include <cstddef>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/core/progress.h"

namespace fluxgs::cli {

/// Keeps the `count` splats that add most, in their order: by the sum of α·T over the pixels of the
/// cameras' images, which counts what is hidden as hidden; ties, and all where no cameras are
/// given, by opacity times area (contribution.h). A pass over the splats for each camera.
void keep_most_contributing(SplatCloud& cloud, std::size_t count,
                            const std::vector<Camera>& cameras, const RenderOptions& options,
                            const Threads& threads, const ProgressReport& progress = {});

}  // namespace fluxgs::cli
