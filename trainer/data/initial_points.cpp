#include "trainer/data/initial_points.h"

#include "trainer/data/random_points.h"
#include "trainer/data/triangulate_features.h"

namespace fluxgs {
namespace {

PointCloud sparse_points(const Dataset& dataset) {
  PointCloud cloud{.positions = dataset.points, .colors = {}, .source = "sparse points"};
  cloud.colors.reserve(dataset.points.size());
  for (const glm::u8vec3& color : dataset.point_colors)
    cloud.colors.push_back(glm::vec3(color) / 255.0F);
  return cloud;
}

}  // namespace

Expected<PointCloud> initial_points(const Dataset& dataset, std::uint64_t seed,
                                    const Threads& threads, const ProgressReport& progress) {
  constexpr std::size_t kFewest = 500, kRandom = 20'000;
  if (!dataset.points.empty()) return sparse_points(dataset);
  if (dataset.train.empty())
    return fail("", "initial points", "no training images, expected at least one");
  PointCloud cloud = triangulate_features(dataset.train, threads, progress);
  return cloud.positions.size() >= kFewest ? cloud : random_points(dataset.train, kRandom, seed);
}

}  // namespace fluxgs
