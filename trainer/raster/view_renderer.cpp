#include "trainer/raster/view_renderer.h"

#include <memory>

#include "trainer/core/profiler.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

ViewRenderer cpu_view_renderer(const SplatCloud& cloud, const RenderOptions& asked,
                               const Threads& threads) {
  const RenderOptions options = for_scene(asked, cloud.filter);
  const auto parameters =
      std::make_shared<const PlanarFloats>(to_parameters(cloud, cloud.sh_degree));
  const auto profiler = std::make_shared<Profiler>();
  const std::shared_ptr<Rasterizer> rasterizer = make_cpu_rasterizer(threads, *profiler);
  return [=](const Camera& camera) -> Expected<PlanarImage> {
    (void)profiler;  // kept for as long as the rasterizer writes to it
    rasterizer->forward(*parameters, camera, options);
    return rasterizer->color();
  };
}

}  // namespace fluxgs
