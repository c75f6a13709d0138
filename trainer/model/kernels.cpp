#include "trainer/model/kernels.h"

#include "trainer/simd/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(AdamKernels, kAdamKernels, adam_kernels)

}  // namespace fluxgs
