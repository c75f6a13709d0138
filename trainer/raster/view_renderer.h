// Renderers as functions of a camera, for measuring scenes.
#pragma once

#include <functional>
#include <memory>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"
#include "trainer/core/profiler.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// Renders a camera's view: 3 channels, 0…1 (limited to that range when scored).
using ViewRenderer = std::function<Expected<PlanarImage>(const Camera&)>;

/// The trainer's rasterizer with the splats of a cloud, of which it copies what it needs. Not
/// thread-safe. `threads` must outlive it.
class CloudRasterizer {
 public:
  CloudRasterizer(const SplatCloud& cloud, const Threads& threads);

  /// Renders with the cloud's screen filter, where the options name none. The result stays as it is
  /// until the next call.
  const Rasterizer& render(const Camera& camera, const RenderOptions& options);

 private:
  PlanarFloats parameters_;
  ScreenFilter filter_;
  Profiler profiler_;  // the rasterizer writes to it
  std::unique_ptr<Rasterizer> rasterizer_;
};

/// The trainer's own renderer for `cloud`. Copies what it needs of the cloud. It has no way to
/// fail.
ViewRenderer cpu_view_renderer(const SplatCloud& cloud, const RenderOptions& options,
                               const Threads& threads);

}  // namespace fluxgs
