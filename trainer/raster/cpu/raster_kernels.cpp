#include "trainer/raster/cpu/raster_kernels.h"

#include "trainer/core/select.h"

namespace fluxgs {

FLUXGS_SELECT_KERNELS(RasterKernels, kRasterKernels, raster_kernels)

}  // namespace fluxgs
