#include "trainer/raster/view_renderer.h"

namespace fluxgs {

CloudRasterizer::CloudRasterizer(const SplatCloud& cloud, const Threads& threads)
    : parameters_(to_parameters(cloud, cloud.sh_degree)),
      filter_(cloud.filter),
      rasterizer_(make_cpu_rasterizer(threads, profiler_)) {}

const Rasterizer& CloudRasterizer::render(const Camera& camera, const RenderOptions& options) {
  rasterizer_->forward(parameters_, camera, for_scene(options, filter_));
  return *rasterizer_;
}

ViewRenderer cpu_view_renderer(const SplatCloud& cloud, const RenderOptions& options,
                               const Threads& threads) {
  const auto rasterizer = std::make_shared<CloudRasterizer>(cloud, threads);
  return [=](const Camera& camera) -> Expected<PlanarImage> {
    return rasterizer->render(camera, options).color();
  };
}

}  // namespace fluxgs
