// The training loss, (1 − λ)·L1 + λ·(1 − SSIM) (paper, eq. loss; Kerbl et al. 2023), and the
// image metrics, which are made of the same sums.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/image.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"
#include "trainer/loss/ssim_kernels.h"

namespace fluxgs {

/// Means over the pixels that count and their channels.
struct PhotometricSums {
  double l1 = 0;    ///< of |x − y|
  double ssim = 0;  ///< of the windows around them
  double loss(double lambda) const { return (1 - lambda) * l1 + lambda * (1 - ssim); }
};

/// 8-bit RGB to planes of 0…1; `out` is made anew if its size differs.
void to_planar(const Image<std::uint8_t>& rgb, const Threads& threads, PlanarImage& out);

/// Adds (1 − α)·shift to planes of an image over a background: the same image over a background
/// that differs by that. `alpha`: 255·α, 1 channel, same size; empty: opaque.
void shift_background(const Image<std::uint8_t>& alpha, const glm::vec3& shift, PlanarImage& image);

/// Gives the pixels of `target` that do not count (0 in `used`, which is of one channel and may be
/// empty) the colours of `color`, so that no comparison sees a difference there.
void fill_unused(const Image<std::uint8_t>& used, const PlanarImage& color, PlanarImage& target);

/// Share of the pixels that count, of those that an image has; 1 where `used` is empty.
double used_share(const Image<std::uint8_t>& used);

/// Reuses its buffers from call to call. Results do not depend on the number of threads.
class PhotometricLoss {
 public:
  explicit PhotometricLoss(const Threads& threads, Isa isa = best_isa())
      : threads_(threads), kernels_(ssim_kernels(isa)) {}

  /// The loss of `color` against `target` (3 channels, same size) and, in gradient(), ∂loss/∂color.
  ///
  /// `used`: 0 where pixels do not count, 1 channel, same size; empty: all count. For pixels p that
  /// count (u_p = 1), of N in the image, and three channels, the gradient is that of
  ///   1/(3N) · Σ u_p·((1 − λ)·|x_p − y_p| + λ·(1 − SSIM_p)),
  /// where the windows of SSIM see, in x and y, the present colours of `color` as constants at
  /// pixels that do not count. N counts all pixels, so that a pixel weighs the same whether others
  /// are masked or not.
  PhotometricSums run(const PlanarImage& color, const PlanarImage& target, double lambda,
                      const Image<std::uint8_t>& used = {});
  const PlanarImage& gradient() const { return gradient_; }

 private:
  void prepare(const PlanarImage& color);
  PhotometricSums run(const PlanarImage& color, const PlanarImage& target, double lambda,
                      const float* used, double count);

  const Threads& threads_;
  const SsimKernels& kernels_;
  PlanarImage partials_, gradient_;  // 3 planes per channel; 3 planes
  PlanarImage filled_, used_;        // the target of a masked image; 1 plane
  std::vector<double> row_ssim_, row_l1_;
};

/// The loss of every pixel, one plane: |x − y| averaged over the channels times 1 − λ, plus λ times
/// 1 − SSIM of the window around the pixel. NaN where an image has one.
PlanarImage loss_map(const PlanarImage& color, const PlanarImage& target, double lambda,
                     const Threads& threads);

/// Peak signal-to-noise ratio in dB over all channels, after limiting both images to 0…1;
/// infinite for equal images, NaN where either has one. Pixels that are 0 in `used` (1 channel;
/// empty: none are) do not count; infinite where none does.
double psnr(const PlanarImage& a, const PlanarImage& b, const Image<std::uint8_t>& used = {});

}  // namespace fluxgs
