// Densification as sampling (Kheradmand et al. 2024, "3D Gaussian Splatting as Markov Chain Monte
// Carlo"): splats that became transparent move to where opaque ones are, new ones start there too,
// noise lets low-opacity splats explore; penalties (penalties.h) set splats free.
#pragma once

#include "trainer/densify/densification.h"
#include "trainer/densify/density_control.h"

namespace fluxgs {

/// Opacity and factor of the scales that `copies` splats (≥ 1) must have in one place to look like
/// one of opacity `opacity` (0…1) (eq. 9 there).
struct Shared {
  double opacity, scale;
};
Shared shared_among(double opacity, int copies);

/// Moves splats below `prune_opacity` to places drawn in proportion to opacity, and adds
/// `mcmc_growth` × the splats there are, up to `target_splats` (or `max_splats`). `cloned` counts
/// those added, `pruned` those moved.
DensifyCounts relocate_and_grow(TrainState& state, const TrainOptions& options);

/// Adds noise to the positions of low-opacity splats, in the shape of each; `rate` is the learning
/// rate of positions (scene units). Results do not depend on the number of threads.
void add_noise(TrainState& state, const DensificationOptions& options, double rate,
               const Threads& threads);

}  // namespace fluxgs
