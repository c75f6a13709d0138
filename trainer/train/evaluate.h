// PSNR and SSIM of a scene against the images of a data set.
#pragma once

#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/core/parallel.h"
#include "trainer/core/progress.h"
#include "trainer/data/dataset.h"
#include "trainer/raster/view_renderer.h"

namespace fluxgs {

struct ViewScore {
  std::string name;
  double psnr = 0;  ///< dB, at most kMaxPsnr
  double ssim = 0;
};

struct Evaluation {
  double psnr = 0, ssim = 0;  ///< means over views
  std::vector<ViewScore> views;
};

/// Scores every image. PSNR over all channels and pixels, SSIM as in the loss, both without the
/// pixels that a mask ignores; transparent ones show the background that the views were loaded
/// with.
Expected<Evaluation> evaluate(const std::vector<View>& views, const ViewRenderer& render,
                              const Threads& threads, const ProgressReport& progress = {});

}  // namespace fluxgs
