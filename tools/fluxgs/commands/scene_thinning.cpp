#include "tools/fluxgs/commands/scene_thinning.h"

#include <cstdint>
#include <vector>

#include "fluxgs/contribution.h"
#include "trainer/core/parameters.h"
#include "trainer/raster/blend_weights.h"

namespace fluxgs::cli {
namespace {

/// Σ α·T of each splat over the images of all cameras.
std::vector<double> weights_in(const SplatCloud& cloud, const std::vector<Camera>& cameras,
                               const RenderOptions& options, const Threads& threads,
                               const ProgressReport& progress) {
  std::vector<double> sums(cloud.size());
  if (cameras.empty()) return sums;
  const PlanarFloats parameters = to_parameters(cloud, 0);  // colours do not matter
  BlendWeights weights(parameters, for_scene(options, cloud.filter), threads);
  ProgressCounter counter(progress, cameras.size());
  for (const Camera& camera : cameras) {
    const std::vector<float>& seen = weights.of(camera);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += double{seen[i]};
    counter.add_one();
  }
  return sums;
}

}  // namespace

void keep_most_contributing(SplatCloud& cloud, std::size_t count,
                            const std::vector<Camera>& cameras, const RenderOptions& options,
                            const Threads& threads, const ProgressReport& progress) {
  if (count >= cloud.size()) return;
  const std::vector<double> seen = weights_in(cloud, cameras, options, threads, progress);
  std::vector<double> anywhere(cloud.size());
  for (std::size_t i = 0; i < anywhere.size(); ++i) anywhere[i] = contribution(cloud, i);
  const auto kept = first_indices(cloud.size(), count, [&](std::uint32_t a, std::uint32_t b) {
    if (seen[a] != seen[b]) return seen[a] > seen[b];
    return anywhere[a] != anywhere[b] ? anywhere[a] > anywhere[b] : a < b;
  });
  cloud = in_order(cloud, kept);
}

}  // namespace fluxgs::cli
