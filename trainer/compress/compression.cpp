#include "trainer/compress/compression.h"

#include <algorithm>
#include <utility>

#include "trainer/compress/view_sensitivity.h"
#include "trainer/core/psnr.h"
#include "trainer/data/dataset.h"
#include "trainer/model/view_budget.h"

namespace fluxgs {

OptionFields CompressionOptions::fields(const TrainOptions& all) {
  return {real("max-psnr-drop",
               "dB of the training images' PSNR that a compact file may cost (an estimate: "
               "quantization errors are taken to be independent of the scene's own errors)",
               max_psnr_drop, 0.001, 10)
              .only_if(all.compact_output, "a .glb to write"),
          real("compress-psnr",
               "PSNR between renders of file and scene that is enough, whatever "
               "--max-psnr-drop (0: no limit)",
               psnr, 0, 100)
              .only_if(all.compact_output, "a .glb to write")};
}

double compressed_psnr(double psnr, const CompressionOptions& options) {
  const double asked = psnr_of_mse(added_mse(mse_of_psnr(psnr), options.max_psnr_drop));
  return options.psnr > 0 ? std::min(asked, options.psnr) : asked;
}

namespace {

/// Views that tell what errors count, and those that measure the error of a trial.
struct SearchViews {
  std::size_t sensitivity, evaluation;
};

constexpr double kSensitivityRenders = 5;  // of a view: one and its scores, forward and backward
constexpr double kTrials = 20;             // and balances, each over all images and with a file
constexpr double kFewestEvaluated = 4, kMostEvaluated = kEvaluationCameras;

SearchViews search_views(std::size_t views, int iterations) {
  // Half of what a run affords is for the one, a quarter for the other, whose files take as long
  const std::size_t affordable = affordable_views(iterations, 2 * kSensitivityRenders);
  const double evaluated = affordable_renders(iterations) / (4 * kTrials);
  return {.sensitivity = std::min({views, kSensitivityViews, affordable}),
          .evaluation = std::min(views, static_cast<std::size_t>(std::clamp(
                                            evaluated, kFewestEvaluated, kMostEvaluated)))};
}

/// Renders that view_sensitivity() takes.
double sensitivity_renders(std::size_t views) {
  const auto seen = static_cast<double>(views);
  return 2 * seen + 3 * std::max(seen, 64.0);
}

/// Work of the search itself, whose trials are measured in so many views.
PhaseWork trial_work(std::size_t views) {
  return {.renders = kTrials * static_cast<double>(views), .files = kTrials};
}

}  // namespace

PhaseWork compact_search_work(std::size_t views, int iterations) {
  const SearchViews seen = search_views(views, iterations);
  PhaseWork work = trial_work(seen.evaluation);
  work.renders += sensitivity_renders(seen.sensitivity);
  return work;
}

Expected<CompactTrial> compact_within(const SplatCloud& cloud, const SplatCloud& shown,
                                      const CompactGoal& goal, CompactOptions start,
                                      const Threads& threads, const WorkControl& control) {
  const SearchViews seen = search_views(goal.cameras.size(), goal.iterations);
  const ProgressParts parts(control.progress, {sensitivity_renders(seen.sensitivity),
                                               trial_work(seen.evaluation).share()});
  start.sensitivity = view_sensitivity(spread_cameras(goal.cameras, seen.sensitivity), shown,
                                       start.networks.has_value(), goal.render, threads,
                                       {parts.part(0), control.stop});
  const SceneError error(shown, spread_cameras(goal.cameras, seen.evaluation), goal.render, threads,
                         control.stop);
  return CompactSearch(cloud, shown, error, std::move(start), parts.part(1))
      .within_loss(goal.decibels);
}

}  // namespace fluxgs
