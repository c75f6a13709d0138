// The views by which a scene stored less exactly is compared with the exact one.
#pragma once

#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/io/sensitivity_weights.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/compress/scene_error.h"
#include "trainer/core/parallel.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

/// At most kEvaluationCameras cameras, evenly spread over the training images; without `data`, on
/// an orbit around the scene, 640x480.
std::vector<Camera> measuring_views(const SplatCloud& cloud, const Dataset* data);

/// trainer/compress/seen_splats.h for all of these images' views, with a bar if it takes long.
SensitivityWeights view_sensitivity(const std::vector<View>& views, const SplatCloud& cloud,
                                    const RenderOptions& render, const Threads& threads);

}  // namespace fluxgs::cli
