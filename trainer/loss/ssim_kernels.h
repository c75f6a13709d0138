// The inner loops of the photometric loss: L1 and SSIM (Wang et al. 2004: 11×11 Gaussian window of
// σ = 1.5, C1 = 0.01², C2 = 0.03²; zero beyond the border, as in 3DGS), with its derivative.
#pragma once

#include <cstddef>
#include <cstdint>

#include "trainer/core/isa.h"

namespace fluxgs {

inline constexpr int kSsimRadius = 5;

/// One channel of an image x against its target y. Planes as in PlanarImage: rows are aligned and
/// padded with zeros up to the pitch.
struct SsimArgs {
  const float* x;
  const float* y;
  const float* used;  ///< plane: 1 where pixels count, 0 where not; null: all do
  int width, height;
  std::size_t pitch;
  float* partials[3];  ///< planes: ∂SSIM/∂μx, ∂SSIM/∂E[x²], ∂SSIM/∂E[xy] of every window
  float* values;       ///< plane: SSIM of the window around each pixel; null: not wanted
  float* gradient;     ///< plane: ∂L/∂x, for L = l1_weight·Σ|x−y| − ssim_weight·Σ SSIM, both sums
                       ///< over pixels that count, and zero at the others
  float l1_weight, ssim_weight;
  double* row_ssim;  ///< Σ SSIM over each row, of windows around pixels that count
  double* row_l1;    ///< Σ |x − y| over each row; x = y where pixels do not count
};

struct SsimKernels {
  /// Floats of scratch memory for the two functions below.
  std::size_t (*scratch_size)(std::size_t pitch);
  /// Fills partials, values, row_ssim and row_l1 for rows [begin, end).
  void (*partials)(const SsimArgs&, int begin, int end, float* scratch);
  /// Fills gradient for rows [begin, end), once the partials of the rows within kSsimRadius exist.
  void (*gradient)(const SsimArgs&, int begin, int end, float* scratch);
  /// `count` interleaved pixels of 8-bit RGB to three rows of 0…1.
  void (*unpack_rgb)(const std::uint8_t* rgb, std::size_t count, float* r, float* g, float* b);
};

const SsimKernels& ssim_kernels(Isa isa);

}  // namespace fluxgs
