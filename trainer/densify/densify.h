// Adaptive density control of vanilla 3DGS (Kerbl et al. 2023, section 5.2): single-view gradients.
#pragma once

#include "trainer/model/options.h"
#include "trainer/model/state.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

struct DensifyCounts {
  std::size_t cloned = 0, split = 0, pruned = 0;
};

/// Adds one iteration's gradients and radii to the statistics of the splats it saw.
void gather_statistics(TrainState& state, const Rasterizer& rasterizer);

/// Clones small and splits large splats whose mean gradient is above the threshold (the largest
/// gradients first where `max_splats` is a limit), removes transparent and oversized ones, and
/// starts the statistics anew. `extent` is the scene's size.
DensifyCounts densify_and_prune(TrainState& state, const TrainOptions& options, double extent);

/// Limits every opacity to `opacity_reset_to` and clears the optimiser's memory of it.
void reset_opacity(TrainState& state, const TrainOptions& options);

}  // namespace fluxgs
