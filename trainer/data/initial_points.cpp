#include "trainer/data/initial_points.h"

#include <algorithm>

#include <fmt/format.h>

#include "trainer/core/median.h"
#include "trainer/core/random.h"
#include "trainer/data/scene_focus.h"
#include "trainer/data/triangulate_features.h"

namespace fluxgs {
namespace {

// Not the pixel's: over a black background half of the splats would be black curtains before the
// cameras, which cost nothing there and hide the scene (chesscat, 2,000 iterations: 16 against 27
// dB)
constexpr glm::vec3 kGrey(0.5f);

// Between the cameras, points in few images grow to floaters that no other image contradicts:
// they cost the test images of chesscat at a quarter 0.2 dB and 0.013 of SSIM
constexpr double kFewestViews = 1.0 / 3;  // of the median's

constexpr double kNear = 0.4, kFar = 2.0;  // times the focus distance

int uniform_index(Random& random, int count) {
  return std::min(static_cast<int>(uniform(random) * count), count - 1);
}

/// Views that have a point in their frames.
std::size_t count_views(const glm::dvec3& point, const std::vector<View>& views) {
  return static_cast<std::size_t>(
      std::ranges::count_if(views, [&](const View& v) { return in_frame(v.camera, point); }));
}

PointCloud sparse_points(const Dataset& dataset) {
  PointCloud cloud{.positions = dataset.points, .colors = {}, .source = "sparse points"};
  cloud.colors.reserve(dataset.points.size());
  for (const glm::u8vec3& color : dataset.point_colors)
    cloud.colors.push_back(glm::vec3(color) / 255.0F);
  return cloud;
}

}  // namespace

PointCloud random_points(const std::vector<View>& views, std::size_t count, std::uint64_t seed) {
  const std::vector<double> distances = focus_distances(views);
  Random random(seed);
  std::vector<glm::dvec3> points;
  std::vector<double> seen;
  // At least half of them stay
  for (std::size_t i = 0; i < 2 * count; ++i) {
    const auto index =
        static_cast<std::size_t>(uniform_index(random, static_cast<int>(views.size())));
    const View& view = views[index];
    const int x = uniform_index(random, view.rgb.width);
    const int y = uniform_index(random, view.rgb.height);
    const double depth = distances[index] * (kNear + (kFar - kNear) * uniform(random));
    const Ray ray = pixel_ray(view.camera, {x + 0.5, y + 0.5});
    const double along = depth / glm::dot(ray.direction, view.camera.forward());
    points.push_back(ray.origin + along * ray.direction);
    seen.push_back(static_cast<double>(count_views(points.back(), views)));
  }
  const double fewest = kFewestViews * median(seen).value_or(0);
  PointCloud cloud{.positions = {}, .colors = {}, .source = "random"};
  for (std::size_t i = 0; i < points.size() && cloud.positions.size() < count; ++i)
    if (seen[i] >= fewest) cloud.positions.emplace_back(points[i]);
  cloud.colors.assign(cloud.positions.size(), kGrey);
  return cloud;
}

Expected<PointCloud> initial_points(const Dataset& dataset, std::uint64_t seed,
                                    const Threads& threads, const ProgressReport& progress) {
  constexpr std::size_t kFewestSparse = 50, kFewest = 500, kRandom = 20'000;
  const std::size_t sparse = dataset.points.size();
  if (sparse >= kFewestSparse) return sparse_points(dataset);
  if (dataset.train.empty())
    return fail("", "initial points", "no training images, expected at least one");
  PointCloud cloud = triangulate_features(dataset.train, threads, progress);
  if (const std::size_t features = cloud.positions.size(); features < kFewest) {
    cloud = random_points(dataset.train, kRandom, seed);
    cloud.source += fmt::format("; only {} features of the images fit their poses", features);
  }
  if (sparse > 0) cloud.source += fmt::format("; {} sparse points are too few", sparse);
  return cloud;
}

}  // namespace fluxgs
