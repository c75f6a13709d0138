// How well a scene shows views that images exist of.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"
#include "trainer/core/progress.h"
#include "trainer/data/dataset.h"

namespace fluxgs {

struct ViewScore {
  std::string name;
  double psnr = 0;  ///< dB, at most kAsGoodAsTheView
  double ssim = 0;
};

struct Evaluation {
  double psnr = 0, ssim = 0;  ///< means over views
  std::vector<ViewScore> views;
};

/// Renders a camera's view: 3 channels, 0…1 (limited to that range when scored).
using ViewRenderer = std::function<Expected<PlanarImage>(const Camera&)>;

/// The trainer's own renderer for `cloud`. Copies what it needs of the cloud.
ViewRenderer cpu_view_renderer(const SplatCloud& cloud, const RenderOptions& options,
                               const Threads& threads);

/// Scores every image. PSNR over all channels and pixels; SSIM as in the loss.
Expected<Evaluation> evaluate(const std::vector<View>& views, const ViewRenderer& render,
                              const Threads& threads, const ProgressReport& progress = {});

}  // namespace fluxgs
