#include "trainer/compress/view_weights.h"

#include <algorithm>

#include "trainer/raster/blend_weights.h"

namespace fluxgs {

ViewWeights view_weights(const PlanarFloats& parameters, const std::vector<Camera>& cameras,
                         const RenderOptions& options, const Threads& threads,
                         const ProgressReport& progress) {
  ViewWeights result;
  result.weights = PlanarFloats(static_cast<int>(cameras.size()), parameters.size());
  BlendWeights weights(parameters, options, threads);
  ProgressCounter counter(progress, cameras.size());
  for (std::size_t v = 0; v < cameras.size(); ++v) {
    std::ranges::copy(weights.of(cameras[v]), result.weights.row(static_cast<int>(v)));
    result.centers.push_back(cameras[v].center());
    result.pixels += static_cast<double>(cameras[v].width) * cameras[v].height;
    counter.add_one();
  }
  return result;
}

}  // namespace fluxgs
