// The optimiser's state and step.
#pragma once

#include "trainer/base/parallel.h"
#include "trainer/model/kernels.h"
#include "trainer/model/parameters.h"

namespace fluxgs {

struct AdamConstants {
  double beta1, beta2, epsilon;
};

/// Learning rates by kind of parameter.
struct LearningRates {
  double position, log_scale, rotation, opacity, sh_dc, sh_rest;
};

/// First and second moments, rows as the parameters.
struct AdamState {
  PlanarFloats first, second;
};

/// One step (counted from 1) on the rows [first_row, end_row), for the splats marked in `visible`
/// (padded to a multiple of 16). The bias correction counts steps of the whole run, as in 3DGS.
void adam_step(PlanarFloats& parameters, AdamState& state, const PlanarFloats& gradient,
               const std::vector<std::uint8_t>& visible, const LearningRates& rates,
               const AdamConstants& constants, int step, int first_row, int end_row,
               const Threads& threads, const AdamKernels& kernels);

}  // namespace fluxgs
