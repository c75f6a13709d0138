// The least degree for each splat, and what it costs.
#include "trainer/compress/adaptive_degree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "support/scenes.h"
#include "trainer/compress/scene_error.h"
#include "trainer/core/psnr.h"
#include "unit/trainer/random_splats.h"

namespace fluxgs {
namespace {

/// Losses of four splats to degree 0, 1, 2.
Unexplained four_splats() {
  const float losses[4][3] = {{8, 4, 2}, {16, 0, 0}, {1, 1, 1}, {3, 5, 2}};
  Unexplained u{.weights = std::vector<float>(4, 2),
                .truncated = PlanarFloats(4, 4),
                .fitted = PlanarFloats(4, 4)};
  for (std::size_t i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d) u.fitted.row(d)[i] = losses[i][d] / 2;  // × weight
  return u;
}

using Degrees = std::vector<std::uint8_t>;

TEST(AdaptiveDegree, TakesTheLeastThatIsGoodEnough) {
  const Unexplained u = four_splats();
  EXPECT_EQ(min_degrees(u, 0), (Degrees{3, 1, 3, 3}));
  EXPECT_EQ(min_degrees(u, 1), (Degrees{3, 1, 0, 3}));
  EXPECT_EQ(min_degrees(u, 2), (Degrees{2, 1, 0, 2}));
  EXPECT_EQ(min_degrees(u, 3.5), (Degrees{2, 1, 0, 0}));
  EXPECT_EQ(min_degrees(u, 4), (Degrees{1, 1, 0, 0}));
  EXPECT_EQ(min_degrees(u, 100), (Degrees{0, 0, 0, 0}));
  EXPECT_DOUBLE_EQ(degree_loss(u, {2, 1, 0, 2}, 10), (2 + 0 + 1 + 2) / 30.0);
}

TEST(AdaptiveDegree, FindsTheThresholdOfALoss) {
  const Unexplained u = four_splats();
  const auto at = [&](double sum) { return threshold_for(u, 10, sum / 30); };
  EXPECT_EQ(at(0), 0);
  EXPECT_EQ(at(0.9), 0);
  EXPECT_EQ(at(1), 1);
  EXPECT_EQ(at(4.9), 1);  // two splats reach 2 together
  EXPECT_EQ(at(5), 2);
  EXPECT_EQ(at(6), 3);
  EXPECT_EQ(at(8), 4);
  EXPECT_EQ(at(12), 8);
  EXPECT_EQ(at(28), 16);
  EXPECT_EQ(at(1e9), 16);
}

TEST(AdaptiveDegree, UsesTheAllowedLossAndNoMore) {
  Random random(3);
  const std::size_t count = 2000;
  PlanarFloats p = test::random_sh(count, 4);
  for (std::size_t i = 0; i < count; ++i) {  // some hardly depend on the view
    const float size = static_cast<float>(std::exp(-3 * std::abs(normal(random))));
    for (int r = row::sh_rest; r < p.rows(); ++r) p.row(r)[i] *= size;
  }
  std::vector<glm::dvec3> directions;
  for (int v = 0; v < 20; ++v) directions.push_back(test::in_cone(0.7, random));
  const ViewWeights views = test::views_along(directions, count, random);
  const Unexplained u = unexplained_variance(p, views, kSpherePrior, Threads(1));
  double before = 0;
  for (const double mse : {0.0, 1e-6, 1e-4, 1e-2, 1.0, 100.0}) {
    const double threshold = threshold_for(u, views.pixels, mse);
    const Degrees degrees = min_degrees(u, threshold);
    const double loss = degree_loss(u, degrees, views.pixels);
    EXPECT_LE(loss, mse * (1 + 1e-9));
    EXPECT_GE(threshold, before);
    before = threshold;
    // Almost all of it is used, unless nothing is left to lose
    if (degrees != Degrees(count, 0)) {
      EXPECT_GE(loss, 0.9 * mse);
    }
    // The fitted colours really lose that much
    const PlanarFloats fitted = fit_to_views(p, degrees, views, kSpherePrior, Threads(1));
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      sum += test::square_loss(views, p, fitted, i);
      for (int r = row::count(degrees[i]); r < fitted.rows(); ++r) EXPECT_EQ(fitted.row(r)[i], 0);
    }
    EXPECT_NEAR(sum / (3 * views.pixels), loss, 1e-3 * loss + 1e-12);
  }
}

TEST(AdaptiveDegree, ImagesLoseLessThanTheBound) {
  const Threads threads(1);
  const SplatCloud cloud = test::random_cloud(1500, 3, 5, 1.0f, 0.15f);
  std::vector<Camera> cameras;
  for (int v = 0; v < 9; ++v)
    cameras.push_back(
        test::camera_at({4 * std::sin(0.2 * v), -1, -4 * std::cos(0.2 * v)}, {0, 0, 0}, 64, 48));
  const PlanarFloats p = to_parameters(cloud, 3);
  const ViewWeights views = view_weights(p, cameras, {}, threads);
  const Unexplained u = unexplained_variance(p, views, kSpherePrior, threads);
  const SceneError error(cloud, cameras, {}, threads);
  for (const double mse : {1e-6, 1e-5, 1e-4, 1e-3}) {
    const Degrees degrees = min_degrees(u, threshold_for(u, views.pixels, mse));
    const PlanarFloats fitted = fit_to_views(p, degrees, views, kSpherePrior, threads);
    const double real = *error.mse(to_cloud(fitted, 3));
    std::printf("allowed %.0e: images %.2e; splats of degree 0 %td, 1 %td, 2 %td, 3 %td\n", mse,
                real, std::ranges::count(degrees, 0), std::ranges::count(degrees, 1),
                std::ranges::count(degrees, 2), std::ranges::count(degrees, 3));
    EXPECT_LT(real, mse);
    EXPECT_GT(real, 0);
  }
}

// The bound is reached where one splat makes up every pixel, but for α ≤ 0.99.
TEST(AdaptiveDegree, TheBoundIsSharp) {
  const Threads threads(1);
  SplatCloud cloud = test::one_splat({0, 0, 0}, 100, 20, glm::vec3(0));
  cloud.sh_degree = 3;
  Random random(2);
  for (int k = 0; k < sh_rest_count(3); ++k)
    cloud.sh_rest.push_back(0.1f * glm::vec3(normal(random), normal(random), normal(random)));
  std::vector<Camera> cameras;
  for (int v = 0; v < 9; ++v)
    cameras.push_back(
        test::camera_at({4 * std::sin(0.2 * v), -1, -4 * std::cos(0.2 * v)}, {0, 0, 0}, 16, 12));
  const PlanarFloats p = to_parameters(cloud, 3);
  const RenderOptions everything{.depth_spread_max = 0};  // The cameras are inside of the splat
  const ViewWeights views = view_weights(p, cameras, everything, threads);
  const Unexplained u = unexplained_variance(p, views, kSpherePrior, threads);
  const SceneError error(cloud, cameras, everything, threads);
  const PlanarFloats fitted = fit_to_views(p, 1, views, kSpherePrior, threads);
  EXPECT_NEAR(*error.mse(to_cloud(fitted, 1)) / degree_loss(u, {1}, views.pixels), 0.99, 0.005);
}

TEST(AdaptiveDegree, DecibelsAddUp) {
  EXPECT_NEAR(psnr_of_mse(0.01) - psnr_of_mse(0.01 + added_mse(0.01, 0.3)), 0.3, 1e-9);
  EXPECT_EQ(added_mse(0.01, 0), 0);
}

}  // namespace
}  // namespace fluxgs
