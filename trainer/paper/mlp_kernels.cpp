#include "trainer/paper/mlp_kernels.h"

#include "trainer/core/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(MlpKernels, kMlpKernels, mlp_kernels)

}  // namespace fluxgs
