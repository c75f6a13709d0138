#include "trainer/loss/kernels.h"

#include "trainer/simd/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(SsimKernels, kSsimKernels, ssim_kernels)

}  // namespace fluxgs
