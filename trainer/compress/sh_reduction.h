// The switch of the training curriculum (paper, "Training Curriculum"): from SH coefficients of the
// third degree to what the finished scene has.
#pragma once

#include <vector>

#include "trainer/compress/view_weights.h"
#include "trainer/data/dataset.h"
#include "trainer/model/options.h"
#include "trainer/model/train_state.h"
#include "trainer/paper/fit_psi.h"

namespace fluxgs {

/// What a reduction left out, by what the training views see.
struct ReductionReport {
  double dropped = 0;           ///< MSE bound (adaptive_degree.h) if the higher bands were dropped
  double unexplained = 0;       ///< … and what fits of the chosen degrees leave
  std::size_t degrees[4] = {};  ///< splats by degree
  double sphere_prior = 0;      ///< of the fits (sphere_prior.h)
  PsiFitReport psi;             ///< energy with Ψ
};

/// Reduces the parameters by `sh_reduce` to `sh_target`, and sets up the networks where there are
/// any. Positions, shapes, opacities and the optimiser's moments of all that stays are kept.
/// `train_mse` is the current mean square error over the training views, by which adaptive degrees
/// are measured.
ReductionReport reduce_appearance(TrainState& state, const TrainOptions& options,
                                  const ViewWeights& views, double train_mse,
                                  const Threads& threads);

}  // namespace fluxgs
