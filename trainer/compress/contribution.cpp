#include "trainer/compress/contribution.h"

#include <algorithm>

#include "fluxgs/math/spherical_harmonics.h"
#include "trainer/model/parameters.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

std::vector<float> splat_contributions(const SplatCloud& cloud, const std::vector<Camera>& cameras,
                                       const RenderOptions& options, const Threads& threads,
                                       const ProgressReport& progress) {
  // A picture's sum depends on a splat's red coefficient by c₀·Σ α·T, as long as no colour is cut
  // off at zero: everything is grey.
  SplatCloud grey = cloud;
  grey.sh_degree = 0;
  grey.sh_rest.clear();
  std::ranges::fill(grey.sh_dc, glm::vec3(0));
  const PlanarFloats parameters = to_parameters(grey, 0);
  StageTimes times;
  const auto rasterizer = make_cpu_rasterizer(threads, times);
  std::vector<double> sums(cloud.size());
  ProgressCounter counter(progress, cameras.size());
  for (const Camera& camera : cameras) {
    rasterizer->forward(parameters, camera, options);
    PlanarImage ones(camera.width, camera.height, 3);
    for (int y = 0; y < camera.height; ++y) std::fill_n(ones.row(0, y), camera.width, 1.0f);
    rasterizer->backward(parameters, ones);
    const float* red = rasterizer->gradient().row(row::sh_dc);
    for (std::size_t i = 0; i < sums.size(); ++i)
      if (rasterizer->visible()[i]) sums[i] += double{red[i]} / math::kSh0;
    counter.add_one();
  }
  return {sums.begin(), sums.end()};
}

}  // namespace fluxgs
