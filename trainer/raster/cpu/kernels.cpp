#include "trainer/raster/cpu/kernels.h"

namespace fluxgs {

namespace baseline {
extern const RasterKernels kRasterKernels;
}
namespace avx2 {
extern const RasterKernels kRasterKernels;
}
namespace avx512 {
extern const RasterKernels kRasterKernels;
}

const RasterKernels& raster_kernels([[maybe_unused]] Isa isa) {
#ifdef FLUXGS_HAVE_AVX512
  if (isa == Isa::avx512) return avx512::kRasterKernels;
#endif
#ifdef FLUXGS_HAVE_AVX2
  if (isa == Isa::avx2) return avx2::kRasterKernels;
#endif
  return baseline::kRasterKernels;
}

}  // namespace fluxgs
