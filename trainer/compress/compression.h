// Compression: how near a compact file is to the scene, and the search for the smallest such file.
#pragma once

#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/compress/compact_search.h"
#include "trainer/core/parallel.h"
#include "trainer/model/options.h"
#include "trainer/model/phase.h"

namespace fluxgs {

/// Precision of the compact file (paper, "Attributes Compression").
struct CompressionOptions {
  static constexpr const char* kTitle = "Compression";
  double max_psnr_drop = 0.3;  ///< dB of the training views' PSNR that quantization may cost
  double psnr = 0;  ///< dB between renders of file and scene that are always enough; 0: no limit

  OptionFields fields(const TrainOptions& all);
};

/// dB between renders of a scene that has `psnr` on the training views, and of its file.
double compressed_psnr(double psnr, const CompressionOptions& options);

/// Error that a file may have.
struct CompactGoal {
  std::vector<Camera> cameras;  ///< errors count as in these or in some of them
  RenderOptions render;
  double decibels = 40;
  int iterations = 30000;  ///< of the training: after a short one fewer cameras are looked at
};

/// Work of compact_within(), after a training of so many views and iterations.
PhaseWork compact_search_work(std::size_t views, int iterations);

/// The smallest compact file of `cloud` (finite, some splats) found whose renders are within the
/// goal of those of `shown`: the same splats with the colours that they are shown with, which
/// `cloud` need not have where networks make them. `start`: step sizes to begin with, and what is
/// not searched for. Fails after a stop.
Expected<CompactTrial> compact_within(const SplatCloud& cloud, const SplatCloud& shown,
                                      const CompactGoal& goal, CompactOptions start,
                                      const Threads& threads, const WorkControl& control = {});

}  // namespace fluxgs
