#include "trainer/raster/cpu/kernels.h"

#include "trainer/simd/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(RasterKernels, kRasterKernels, raster_kernels)

}  // namespace fluxgs
