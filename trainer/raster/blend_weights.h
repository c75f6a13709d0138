// Shares of the splats in one image.
#pragma once

#include <memory>
#include <vector>

#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// Σ α·T over the pixels of a view for each splat: the weight with which its colour enters the
/// image.
class BlendWeights {
 public:
  /// `parameters` and `threads` must outlive this. Colours do not matter, but a splat whose colour
  /// is not finite is not drawn, as in training.
  BlendWeights(const PlanarFloats& parameters, const RenderOptions& options,
               const Threads& threads);

  /// One finite weight ≥ 0 a splat, 0 where it is not seen; valid until the next call. `used`: 0 at
  /// pixels that do not count, 1 channel; empty: all count.
  const std::vector<float>& of(const Camera& camera, const Image<std::uint8_t>& used = {});
  /// Number of pixels of that view, those that count, that each splat reaches.
  const std::vector<float>& pixels() const { return pixels_; }

 private:
  const PlanarFloats& parameters_;
  RenderOptions options_;
  Profiler profiler_;
  std::unique_ptr<Rasterizer> rasterizer_;
  std::vector<float> weights_, pixels_;
};

}  // namespace fluxgs
