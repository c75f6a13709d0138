#include "trainer/core/adam_kernels.h"

#include "trainer/core/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(AdamKernels, kAdamKernels, adam_kernels)

}  // namespace fluxgs
