#include "trainer/compress/view_weights.h"

#include <algorithm>

#include "trainer/raster/blend_weights.h"

namespace fluxgs {

ViewWeights view_weights(const PlanarFloats& parameters, const std::vector<Camera>& cameras,
                         const RenderOptions& options, const Threads& threads,
                         const WorkControl& control) {
  ViewWeights result;
  result.weights = PlanarFloats(static_cast<int>(cameras.size()), parameters.size());
  BlendWeights weights(parameters, options, threads);
  ProgressCounter counter(control.progress, cameras.size());
  for (const Camera& camera : cameras) {
    result.centers.push_back(camera.center());
    result.pixels += static_cast<double>(camera.width) * camera.height;
  }
  for (std::size_t v = 0; v < cameras.size() && !control.stopped(); ++v) {
    std::ranges::copy(weights.of(cameras[v]), result.weights.row(static_cast<int>(v)));
    counter.add_one();
  }
  return result;
}

}  // namespace fluxgs
