#include "trainer/paper/energy_kernels.h"

#include "trainer/core/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(EnergyKernels, kEnergyKernels, energy_kernels)

}  // namespace fluxgs
