// The optimiser's inner loop.
#pragma once

#include <cstddef>
#include <cstdint>

#include "trainer/core/isa.h"

namespace fluxgs {

/// Adam (Kingma & Ba 2015) on one row of parameters, for visible splats only: the moments of the
/// others stay as they are ("sparse Adam", Mallick et al. 2024).
struct AdamArgs {
  float* parameter;
  float* first;   ///< first moment
  float* second;  ///< second moment
  const float* gradient;
  const std::uint8_t* visible;
  float step;               ///< learning rate / (1 − β₁ᵗ)
  float second_correction;  ///< 1 / (1 − β₂ᵗ)
  float beta1, beta2, epsilon;
};

struct AdamKernels {
  /// Entries [begin, end); begin is a multiple of 16, arrays are padded to one.
  void (*adam)(const AdamArgs&, std::size_t begin, std::size_t end);
};

const AdamKernels& adam_kernels(Isa isa);

}  // namespace fluxgs
