#include "trainer/raster/cpu/kernels/kernels_isa.h"

namespace fluxgs::FLUXGS_ISA {

extern const RasterKernels kRasterKernels;
const RasterKernels kRasterKernels{project, bin, forward, backward, score, gradient};

}  // namespace fluxgs::FLUXGS_ISA
