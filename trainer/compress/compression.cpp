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

Expected<CompactTrial> compact_within(const SplatCloud& cloud, const SplatCloud& shown,
                                      const CompactGoal& goal, CompactOptions start,
                                      const Threads& threads,
                                      const std::function<void(const CompactTrial&)>& on_trial) {
  start.sensitivity =
      view_sensitivity(goal.cameras, shown, start.networks.has_value(), goal.render, threads);
  const SceneError error(shown, spread_cameras(goal.cameras, kEvaluationCameras), goal.render,
                         threads);
  return CompactSearch(cloud, shown, error, std::move(start), on_trial).within_loss(goal.decibels);
}

}  // namespace fluxgs
