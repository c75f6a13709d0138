// Sensitivity of the renders of some views to errors of each splat, for the compact encoder.
#pragma once

#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/io/sensitivity_weights.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/compress/view_weights.h"
#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/core/progress.h"

namespace fluxgs {

/// Σ α·T of each splat over all pixels of all views: the weight with which its colour enters the
/// images (the contribution of the paper's section on compression).
std::vector<float> total_weights(const ViewWeights& views);

/// Weight of the whole sphere beside the views (compress/sh_fit.h) in errors of SH
/// coefficients. At the same error in training views, 0.01 instead of 1e-3 makes files of five
/// captures up to 1.7% larger and other views better by 0.02 to 0.06 dB, by 0.18 and 0.23 where
/// training views are few (banana: 12); with 0.1 files grow faster than errors fall.
inline constexpr double kSphereShare = 0.01;

/// SensitivityWeights::sh_factors of a cloud with these parameters.
std::vector<float> sh_factors(const PlanarFloats& parameters, const ViewWeights& views,
                              const Threads& threads);

/// The most views that view_sensitivity() looks at, so that its time has a limit.
inline constexpr std::size_t kSensitivityViews = 100;

/// Costs of errors in the images of the cameras, or of kSensitivityViews of them, evenly spread;
/// where networks make the colours, only weights. Of no use after a stop.
SensitivityWeights view_sensitivity(const std::vector<Camera>& cameras, const SplatCloud& cloud,
                                    bool has_networks, const RenderOptions& render,
                                    const Threads& threads, const WorkControl& control = {});

}  // namespace fluxgs
