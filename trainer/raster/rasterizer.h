// The differentiable renderer, whatever it runs on.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/render_options.h"
#include "trainer/core/isa.h"
#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/core/planar_image.h"
#include "trainer/core/profiler.h"
#include "trainer/raster/score.h"

namespace fluxgs {

/// Counts of one forward pass.
struct RasterCounts {
  std::size_t visible = 0;        ///< splats that can touch the image
  std::size_t tile_pairs = 0;     ///< splat–tile pairs
  std::uint64_t pixel_pairs = 0;  ///< contributing splat–pixel pairs, when asked for
};

class Rasterizer {
 public:
  virtual ~Rasterizer() = default;

  /// Splats that a camera can see, without rendering: visible() as forward() would leave it, but
  /// for colours that are not finite.
  virtual const std::vector<std::uint8_t>& find_visible(const PlanarFloats& parameters,
                                                        const Camera& camera,
                                                        const RenderOptions& options) = 0;

  /// Renders the parameters (rows as in model/parameters.h). The image, gradients and visibility
  /// stay valid until the next call. Results are the same bytes for any number of threads.
  virtual void forward(const PlanarFloats& parameters, const Camera& camera,
                       const RenderOptions& options) = 0;
  virtual const PlanarImage& color() const = 0;  ///< 3 channels, including the background

  /// 1 channel: the share of the background at each pixel, 1 less the opacity there.
  virtual const PlanarImage& transmittance() const = 0;

  /// ∂L/∂parameters, given ∂L/∂colour for the last forward pass (3 channels, same size) and, where
  /// L depends on the transmittance otherwise than by the background's colour, ∂L/∂transmittance
  /// (1 channel; may be null).
  virtual void backward(const PlanarFloats& parameters, const PlanarImage& color_gradient,
                        const PlanarImage* transmittance_gradient) = 0;
  /// Rows as the parameters; meaningful where visible()[i] is 1 and up to the degree rendered.
  virtual const PlanarFloats& gradient() const = 0;
  virtual PlanarFloats& gradient() = 0;  ///< for whoever adds to it
  /// |∂L/∂centre| per splat in normalised device coordinates, as 3DGS thresholds it.
  virtual const float* center_gradient() const = 0;
  /// 1 for splats that the last forward pass could see (and whose gradient is finite); padded to a
  /// multiple of 16 with zeros.
  virtual const std::vector<std::uint8_t>& visible() const = 0;
  /// The larger half-extent (px) of splat i's box {α ≥ α_min}; meaningful where visible.
  virtual float screen_radius(std::size_t i) const = 0;

  /// The scores of the last forward pass, rows as in raster/score.h, for two maps (planes of the
  /// image's size). A third plane, if there is one, is 1 at pixels that count and 0 at others,
  /// which add nothing. Zero for splats that are not visible; valid until the next call.
  virtual const PlanarFloats& score(const PlanarImage& maps, ScoreWeight weight) = 0;

  /// The exact cost of removing each splat alone from the last forward pass's image, rows as in
  /// raster/score.h. `target`: 3 channels, the size of the image; a fourth, if there is one, is 1
  /// at pixels that count and 0 at others. Zero for splats that are not visible; valid until the
  /// next call.
  virtual const PlanarFloats& removal(const PlanarImage& target) = 0;

  virtual RasterCounts counts() const = 0;
  virtual std::uint64_t rejected_gradients() const = 0;  ///< not finite, since the beginning
};

struct CpuRasterizerOptions {
  Isa isa = best_isa();
  bool count_pixel_pairs = false;
};

/// `threads` and `profiler` must outlive the rasterizer.
std::unique_ptr<Rasterizer> make_cpu_rasterizer(const Threads& threads, Profiler& profiler,
                                                const CpuRasterizerOptions& options = {});

}  // namespace fluxgs
