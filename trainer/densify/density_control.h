// Adaptive density control: which splats are cloned, split and removed (Kerbl et al. 2023, section
// 5.2; paper, "Accurate Densification", "Moderate Pruning").
#pragma once

#include "trainer/densify/splat_scores.h"
#include "trainer/model/options.h"
#include "trainer/model/train_state.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// Splats that got a copy, became two, were removed; by MCMC: added, –, moved.
struct DensifyCounts {
  std::size_t cloned = 0, split = 0, pruned = 0;
};

/// Adds one iteration's gradients and radii to the statistics of the splats it saw.
void gather_statistics(TrainState& state, const Rasterizer& rasterizer);

/// Clones small and splits large splats whose mean gradient is above the threshold (and, for
/// Densify::multiview, whose S⁺ is above its quantile), the first by rank where there is room for
/// some only; removes transparent and oversized ones; limits opacities; and starts the statistics
/// anew. With `target_splats`, as many are added as lead there by the last densification, whatever
/// their gradients. `extent` is the scene's size. `scores`: of the splats as they are now; may be
/// null where options ask for none.
DensifyCounts densify_and_prune(TrainState& state, const TrainOptions& options, double extent,
                                const SplatScores* scores);

/// Removes splats between or after densifications, by `late_prune`; for LatePrune::contribution,
/// which removes those first that contribute the least for their place in a file and the pixels
/// that are drawn for them, the scores must be of all training views. Never below `target_splats`.
DensifyCounts prune_late(TrainState& state, const TrainOptions& options, const SplatScores& scores);

/// Limits every opacity to `opacity_reset_to` and clears the optimiser's memory of it.
void reset_opacity(TrainState& state, const TrainOptions& options);

}  // namespace fluxgs
