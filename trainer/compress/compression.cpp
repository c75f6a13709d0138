#include "trainer/compress/compression.h"

#include <algorithm>
#include <utility>

#include "trainer/compress/view_sensitivity.h"
#include "trainer/core/psnr.h"
#include "trainer/data/dataset.h"

namespace fluxgs {

OptionFields CompressionOptions::fields(const TrainOptions& all) {
  const bool stores = used || all.compact_output;
  const char* needed = "a .glb to write, or --quantize-aware on";
  return {real("max-psnr-drop",
               "dB of PSNR that a compact file costs before training makes up for it (an estimate: "
               "quantization errors are taken to be independent of the scene's own errors)",
               max_psnr_drop, 0.001, 10)
              .only_if(stores, needed),
          real("compress-psnr",
               "PSNR between renders of file and scene that is enough, whatever "
               "--max-psnr-drop (0: no limit)",
               psnr, 0, 100)
              .only_if(stores, needed)};
}

double compressed_psnr(double psnr, const CompressionOptions& options) {
  const double asked = psnr_of_mse(added_mse(mse_of_psnr(psnr), options.max_psnr_drop));
  return options.psnr > 0 ? std::min(asked, options.psnr) : asked;
}

namespace {

/// Renders that view_sensitivity() takes: one and its scores, then forward and backward.
double sensitivity_renders(std::size_t views) {
  const auto seen = static_cast<double>(std::min(views, kSensitivityViews));
  return 2 * seen + 3 * std::max(seen, 64.0);
}

/// The search: about so many trials and balances, each over all images and with a file.
constexpr double kTrials = 40;
constexpr PhaseWork kSearch{.renders = kTrials * kEvaluationCameras, .files = kTrials};

}  // namespace

PhaseWork compact_search_work(std::size_t views) {
  return {.renders = sensitivity_renders(views) + kSearch.renders, .files = kSearch.files};
}

Expected<CompactTrial> compact_within(const SplatCloud& cloud, const SplatCloud& shown,
                                      const CompactGoal& goal, CompactOptions start,
                                      const Threads& threads, const WorkControl& control) {
  const ProgressParts parts(control.progress,
                            {sensitivity_renders(goal.cameras.size()), kSearch.share()});
  start.sensitivity = view_sensitivity(goal.cameras, shown, start.networks.has_value(), goal.render,
                                       threads, {parts.part(0), control.stop});
  const SceneError error(shown, spread_cameras(goal.cameras, kEvaluationCameras), goal.render,
                         threads, control.stop);
  return CompactSearch(cloud, shown, error, std::move(start), parts.part(1))
      .within_loss(goal.decibels);
}

}  // namespace fluxgs
