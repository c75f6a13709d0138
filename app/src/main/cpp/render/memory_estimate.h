// Estimate of the graphics memory of a scene, before anything is allocated.
#pragma once

#include <cstdint>

#include "fluxgs/splat_degree.h"
#include "render/render_target.h"
#include "render/settings.h"

namespace fluxgs::render {

struct MemoryEstimate {
  std::size_t scene = 0;  ///< bytes of the splats
  std::size_t frame = 0;  ///< bytes of projected_splats, keys, the sorter's buffers and the draw's
  std::size_t targets = 0;  ///< bytes of the image and of what it is blended in
  std::size_t reading = 0;  ///< bytes that are taken while the image of a window is read

  std::size_t taken() const { return scene + frame + targets; }
  std::size_t total() const { return taken() + reading; }
};

/// Size and formats of an image.
struct TargetPlan {
  int width = 0, height = 0;
  TargetFormat format = TargetFormat::rgba8;
  Accumulation accumulation = Accumulation::direct;
  double scale = 1;
  bool marks = false;       ///< with depths for SaturationMarks; not for_window
  bool for_window = false;  ///< of RenderTarget::create_for_window(), for any scale
};

/// Bytes of a pixel of the image, and of what it is blended in.
std::size_t pixel_bytes(TargetFormat format);
std::size_t blend_pixel_bytes(const TargetPlan& target);

/// The sum of the sizes that Renderer and RenderTarget ask the driver for; drivers round each up.
/// `settings` as the renderer uses them: texture_fetch where the driver makes it necessary.
MemoryEstimate estimate_memory(const DegreeCounts& splats, const RendererSettings& settings,
                               const TargetPlan& target);

/// The largest number of splats of a scene whose estimate is at most `bytes`, whichever they are
/// (largest_of()); 0 where not even the targets fit.
std::uint64_t splats_that_fit(std::size_t bytes, const DegreeCounts& scene,
                              const RendererSettings& settings, const TargetPlan& target);

}  // namespace fluxgs::render
