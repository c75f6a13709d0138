#include "trainer/appearance/mlp_kernels.h"

#include "trainer/simd/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(MlpKernels, kMlpKernels, mlp_kernels)

}  // namespace fluxgs
