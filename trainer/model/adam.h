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

/// The constants of one step, with the corrections of the moments' bias.
class AdamStep {
 public:
  AdamStep(const AdamConstants& constants, int step);  ///< counted from 1

  /// What a kernel needs for one row of numbers, its moments and its gradient. Entries where
  /// `chosen` (padded to a multiple of 16) is 0 stay as they are.
  AdamArgs args(float* values, float* first, float* second, const float* gradient,
                const std::uint8_t* chosen, double rate) const;

 private:
  AdamConstants constants_;
  double correction1_, correction2_;
};

/// One step (counted from 1) on the rows [first_row, end_row), for the splats marked in `visible`
/// (padded to a multiple of 16). The bias correction counts steps of the whole run, as in 3DGS.
void adam_step(PlanarFloats& parameters, AdamState& state, const PlanarFloats& gradient,
               const std::vector<std::uint8_t>& visible, const LearningRates& rates,
               const AdamConstants& constants, int step, int first_row, int end_row,
               const Threads& threads, const AdamKernels& kernels);

}  // namespace fluxgs
