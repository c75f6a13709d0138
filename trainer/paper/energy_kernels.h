// The inner loop of the energy moments.
#pragma once

#include <cstddef>

#include "trainer/core/isa.h"

namespace fluxgs {

/// A direction: the basis functions beyond the constant one there, and its weight times
/// (1, x, y, z).
struct EnergySample {
  float basis[15];
  float moments[4];
};

/// One colour channel of splats. Arrays of splats are aligned and padded to packs of lanes.
struct EnergyArgs {
  const float* coefficients[15];  ///< of each function, for all splats
  int first, end;                 ///< the functions that make up the residual
  const EnergySample* samples;
  std::size_t sample_count;
  float* moments[4];  ///< out: Σ moments·max(0, residual); finite, 0 where that is not
};

struct EnergyKernels {
  /// Splats [begin, end); begin is a multiple of 16.
  void (*energy)(const EnergyArgs&, std::size_t begin, std::size_t end);
};

const EnergyKernels& energy_kernels(Isa isa);

}  // namespace fluxgs
