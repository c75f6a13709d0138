// How much each view sees of each splat.
#include "trainer/compress/view_weights.h"

#include <gtest/gtest.h>

#include <limits>

#include "fluxgs/math/spherical_harmonics.h"
#include "support/scenes.h"
#include "trainer/compress/view_sensitivity.h"
#include "trainer/train/evaluate.h"

namespace fluxgs {
namespace {

std::vector<Camera> some_cameras() {
  return {test::camera_at({0, 0, -4}, {0, 0, 0}, 64, 48),
          test::camera_at({3, -1, -2}, {0, 0, 0}, 51, 33)};
}

double sum_of_red(const SplatCloud& cloud, const Camera& camera, const Threads& threads) {
  const auto image = cpu_view_renderer(cloud, {}, threads)(camera);
  double sum = 0;
  for (int y = 0; y < image->height(); ++y)
    for (int x = 0; x < image->width(); ++x) sum += double{image->row(0, y)[x]};
  return sum;
}

TEST(ViewWeights, AreWhatAChangeOfColourDoesToTheImage) {
  const Threads threads(1);
  SplatCloud cloud = test::random_cloud(60, 3, 2, 1.0f, 0.2f);
  const auto cameras = some_cameras();
  const ViewWeights views = view_weights(to_parameters(cloud, 3), cameras, {}, threads);
  ASSERT_EQ(views.weights.rows(), 2);
  ASSERT_EQ(views.weights.size(), cloud.size());
  EXPECT_EQ(views.pixels, 64 * 48 + 51 * 33);
  EXPECT_NEAR(glm::distance(views.centers[1], glm::dvec3(3, -1, -2)), 0, 1e-12);
  for (glm::vec3& dc : cloud.sh_dc) dc = glm::vec3(5);  // never cut off
  for (std::size_t i = 0; i < cloud.size(); i += 7)
    for (int v = 0; v < 2; ++v) {
      const Camera& camera = cameras[static_cast<std::size_t>(v)];
      const double before = sum_of_red(cloud, camera, threads);
      cloud.sh_dc[i].x += 4;
      const double after = sum_of_red(cloud, camera, threads);
      cloud.sh_dc[i].x -= 4;
      EXPECT_NEAR(views.weights.row(v)[i], (after - before) / (4 * math::kSh0), 2e-2);
    }
}

TEST(ViewWeights, AddUpToTheContributions) {
  const Threads threads(1);
  const SplatCloud cloud = test::random_cloud(500, 2, 3);
  const ViewWeights views = view_weights(to_parameters(cloud, 3), some_cameras(), {}, threads);
  const auto contributions = view_sensitivity(some_cameras(), cloud, false, {}, threads).weights;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_FLOAT_EQ(views.weights.row(0)[i] + views.weights.row(1)[i], contributions[i]);
}

/// Cameras beside each other that look the same way.
std::vector<Camera> many_cameras(std::size_t count) {
  std::vector<Camera> cameras(count, test::camera_in_front(24, 18));
  for (std::size_t i = 0; i < count; ++i)
    cameras[i].translation.x = 0.5 - static_cast<double>(i) / static_cast<double>(count);
  return cameras;
}

TEST(ViewSensitivity, LooksAtAHundredOfManyViews) {
  const Threads threads(2);
  const SplatCloud cloud = test::random_cloud(100, 1, 3);
  const auto cameras = many_cameras(250);
  std::size_t images = 0;
  const auto some = view_sensitivity(cameras, cloud, false, {}, threads,
                                     {.progress = [&](std::size_t, std::size_t) { ++images; }});
  EXPECT_EQ(images, 2 * kSensitivityViews);
  const auto spread =
      view_sensitivity(spread_cameras(cameras, kSensitivityViews), cloud, false, {}, threads);
  EXPECT_EQ(some.weights, spread.weights);
  EXPECT_EQ(some.scale, spread.scale);
  // As all of them say, for each view
  const auto all = total_weights(view_weights(to_parameters(cloud, 1), cameras, {}, threads));
  for (std::size_t i = 0; i < all.size(); ++i)
    EXPECT_NEAR(2.5f * some.weights[i], all[i], 0.1f * all[i] + 0.5f) << i;
}

TEST(ViewSensitivity, StopsAtTheNextView) {
  const Threads threads(2);
  const SplatCloud cloud = test::random_cloud(100, 1, 3);
  std::size_t images = 0;
  (void)view_sensitivity(
      many_cameras(50), cloud, false, {}, threads,
      {[&](std::size_t, std::size_t) { ++images; }, [&] { return images == 3; }});
  EXPECT_EQ(images, 3u);
}

TEST(ViewWeights, SplatsThatAreNotDrawnHaveNoneAndHideNothing) {
  const Threads threads(1);
  const SplatCloud cloud = test::random_cloud(100, 3, 4, 0.3f, 0.3f);
  PlanarFloats with = to_parameters(cloud, 3), without = with;
  with.row(row::sh_rest + 20)[3] = std::numeric_limits<float>::quiet_NaN();
  without.row(row::opacity)[3] = -100;
  const ViewWeights a = view_weights(with, some_cameras(), {}, threads);
  const ViewWeights b = view_weights(without, some_cameras(), {}, threads);
  for (int v = 0; v < 2; ++v) {
    EXPECT_EQ(a.weights.row(v)[3], 0);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      EXPECT_EQ(a.weights.row(v)[i], b.weights.row(v)[i]);
  }
}

TEST(ViewWeights, NoViewsNoSplats) {
  const Threads threads(1);
  EXPECT_EQ(view_weights(PlanarFloats(row::count(3), 5), {}, {}, threads).weights.rows(), 0);
  EXPECT_EQ(
      view_weights(PlanarFloats(row::count(3), 0), some_cameras(), {}, threads).weights.size(), 0u);
}

}  // namespace
}  // namespace fluxgs
