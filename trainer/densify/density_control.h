// Adaptive density control: which splats are cloned, split and removed (Kerbl et al. 2023, section
// 5.2; paper, "Accurate Densification", "Moderate Pruning").
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/densify/splat_scores.h"
#include "trainer/model/phase.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// Splats that got a copy, became two, were removed; by MCMC: added, –, moved.
struct DensifyCounts {
  std::size_t cloned = 0, split = 0, pruned = 0;
};

/// Adds one iteration's gradients and radii to the statistics of the splats it saw. `masked`: some
/// pixels did not count; splats without any gradient were seen there only, and are left out.
void gather_statistics(TrainState& state, const Rasterizer& rasterizer, bool masked = false);

/// Mean gradient of splat i since the last densification.
float mean_gradient(const TrainState& state, std::size_t i);

/// Clones small and splits large splats whose mean gradient is above the threshold (and, for
/// Densify::multiview, whose S⁺ is above its quantile), the first by rank where there is room for
/// some only; removes transparent and oversized ones; limits opacities; and starts the statistics
/// anew. With `target_splats`, as many are added as lead there by the last densification, whatever
/// their gradients. `extent` is the scene's size. `scores`: of the splats as they are now; may be
/// null where options ask for none.
DensifyCounts densify_and_prune(TrainState& state, const TrainOptions& options, double extent,
                                const SplatScores* scores);

/// A decision about one splat.
enum class RefineAction : std::uint8_t { keep, clone, split, prune };

/// Carries out one decision for each splat. Splats that stay keep their order and moments; copies,
/// then halves of split splats follow, with moments of zero.
DensifyCounts apply_refinement(TrainState& state, const TrainOptions& options,
                               const std::vector<RefineAction>& actions);

/// Scores of all splats over views drawn by ScoreOptions.
SplatScores sampled_scores(Training& training);

}  // namespace fluxgs
