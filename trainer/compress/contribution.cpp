#include "trainer/compress/contribution.h"

#include "trainer/raster/blend_weights.h"

namespace fluxgs {

std::vector<float> splat_contributions(const SplatCloud& cloud, const std::vector<Camera>& cameras,
                                       const RenderOptions& options, const Threads& threads,
                                       const ProgressReport& progress) {
  const PlanarFloats parameters = to_parameters(cloud, cloud.sh_degree);
  BlendWeights weights(parameters, options, threads);
  std::vector<double> sums(cloud.size());
  ProgressCounter counter(progress, cameras.size());
  for (const Camera& camera : cameras) {
    const std::vector<float>& view = weights.of(camera);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += double{view[i]};
    counter.add_one();
  }
  return {sums.begin(), sums.end()};
}

}  // namespace fluxgs
