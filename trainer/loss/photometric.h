// The training loss, (1 − λ)·L1 + λ·(1 − SSIM) (paper, eq. loss; Kerbl et al. 2023), and the
// image metrics, which are made of the same sums.
#pragma once

#include <cstdint>
#include <vector>

#include "fluxgs/image.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"
#include "trainer/loss/ssim_kernels.h"

namespace fluxgs {

struct PhotometricSums {
  double l1 = 0;    ///< mean |x − y| over pixels and channels
  double ssim = 0;  ///< mean over pixels and channels
  double loss(double lambda) const { return (1 - lambda) * l1 + lambda * (1 - ssim); }
};

/// 8-bit RGB to planes of 0…1; `out` is made anew if its size differs.
void to_planar(const Image<std::uint8_t>& rgb, const Threads& threads, PlanarImage& out);

/// Reuses its buffers from call to call. Results do not depend on the number of threads.
class PhotometricLoss {
 public:
  explicit PhotometricLoss(const Threads& threads, Isa isa = best_isa())
      : threads_(threads), kernels_(ssim_kernels(isa)) {}

  /// The loss of `color` against `target` (3 channels, same size) and, in gradient(), ∂loss/∂color.
  PhotometricSums run(const PlanarImage& color, const PlanarImage& target, double lambda);
  const PlanarImage& gradient() const { return gradient_; }

 private:
  void prepare(const PlanarImage& color);

  const Threads& threads_;
  const SsimKernels& kernels_;
  PlanarImage partials_, gradient_;  // 3 planes per channel; 3 planes
  std::vector<double> row_ssim_, row_l1_;
};

/// Peak signal-to-noise ratio in dB over all channels, after limiting both images to 0…1;
/// infinite for equal images, NaN where either has one.
double psnr(const PlanarImage& a, const PlanarImage& b);

}  // namespace fluxgs
