#include "trainer/loss/ssim_kernels.h"

#include "trainer/core/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(SsimKernels, kSsimKernels, ssim_kernels)

}  // namespace fluxgs
