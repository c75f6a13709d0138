#include "trainer/raster/cpu/kernels/kernels_isa.h"

namespace fluxgs::FLUXGS_ISA {

extern const RasterKernels kRasterKernels;
const RasterKernels kRasterKernels{project, bin, forward, backward, score, removal, gradient};

}  // namespace fluxgs::FLUXGS_ISA
