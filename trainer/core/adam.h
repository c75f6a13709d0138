// The optimiser's state and step.
#pragma once

#include "trainer/core/adam_kernels.h"
#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"

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

/// One step of Adam, counted from 1, on any values.
class AdamStep {
 public:
  AdamStep(const AdamConstants& constants, int step, const AdamKernels& kernels);

  /// A row of values that is padded to a multiple of 16, with its moments and its gradient.
  /// Entries where `chosen` (padded, too) is 0 stay as they are.
  struct Row {
    float *values, *first, *second;
    const float* gradient;
    const std::uint8_t* chosen;
    double rate;
  };
  void run(const Row& row, std::size_t begin, std::size_t end) const;  ///< begin: a multiple of 16

 private:
  AdamConstants constants_;
  double correction1_, correction2_;  ///< of the moments' bias
  const AdamKernels& kernels_;
};

struct RowRange {
  int first, end;
};

/// A step on some rows of the splats marked in `visible` (padded to a multiple of 16). Its number
/// is that of the whole run, as in 3DGS.
void adam_step(PlanarFloats& parameters, AdamState& state, const PlanarFloats& gradient,
               const std::vector<std::uint8_t>& visible, const LearningRates& rates,
               const AdamStep& adam, RowRange rows, const Threads& threads);

}  // namespace fluxgs
