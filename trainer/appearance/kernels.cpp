#include "trainer/appearance/kernels.h"

#include "trainer/simd/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(EnergyKernels, kEnergyKernels, energy_kernels)

}  // namespace fluxgs
