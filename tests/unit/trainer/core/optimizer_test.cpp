// Adam and the first splats.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fluxgs/math/spherical_harmonics.h"
#include "support/scenes.h"
#include "trainer/core/adam.h"
#include "trainer/train/initialize.h"

namespace fluxgs {
namespace {

class Adam : public testing::TestWithParam<Isa> {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, Adam, testing::ValuesIn(available_isas()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

TEST_P(Adam, FollowsItsDefinitionForVisibleSplatsOnly) {
  const std::size_t n = 37;
  const Threads threads(2);
  PlanarFloats p = to_parameters(test::random_cloud(n, 1, 1), 1);
  const PlanarFloats start = p;
  AdamState state{PlanarFloats(p.rows(), n), PlanarFloats(p.rows(), n)};
  const PlanarFloats gradient = to_parameters(test::random_cloud(n, 1, 2), 1);
  std::vector<std::uint8_t> visible(p.stride() + 16, 0);
  for (std::size_t i = 0; i < n; ++i) visible[i] = i % 3 != 0;
  const LearningRates rates{0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  const AdamConstants constants{0.9, 0.999, 1e-15};
  for (int step = 1; step <= 5; ++step)
    adam_step(p, state, gradient, visible, rates,
              AdamStep(constants, step, adam_kernels(GetParam())), {0, row::count(1)}, threads);

  const double rate_of_row[] = {0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3,
                                0.3, 0.3, 0.3, 0.4, 0.5, 0.5, 0.5};
  for (int r = 0; r < p.rows(); ++r)
    for (std::size_t i = 0; i < n; ++i) {
      double x = start.row(r)[i], m = 0, v = 0;
      const double g = gradient.row(r)[i], rate = r < 14 ? rate_of_row[r] : 0.6;
      for (int step = 1; visible[i] && step <= 5; ++step) {
        m = 0.9 * m + 0.1 * g;
        v = 0.999 * v + 0.001 * g * g;
        x -= rate * (m / (1 - std::pow(0.9, step))) /
             (std::sqrt(v / (1 - std::pow(0.999, step))) + 1e-15);
      }
      ASSERT_NEAR(p.row(r)[i], x, 2e-4 * rate + 1e-6 * std::abs(x))
          << "row " << r << ", splat " << i;
    }
}

TEST(Initialize, ScaleIsTheDistanceToTheThreeNearestNeighbours) {
  const Threads threads(2);
  PointCloud points;
  points.positions = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {100, 100, 100}};
  points.colors.assign(5, glm::vec3(0.75f, 0.5f, 0.25f));
  const SplatCloud cloud = splats_from_points(points, 0.1, threads);
  ASSERT_EQ(cloud.size(), 5u);
  EXPECT_NEAR(cloud.log_scales[0].x, 0.5 * std::log((1.0 + 4 + 9) / 3), 1e-5);
  EXPECT_NEAR(1 / (1 + std::exp(-cloud.opacity_logits[0])), 0.1, 1e-6);
  EXPECT_NEAR(0.5 + math::kSh0 * static_cast<double>(cloud.sh_dc[0].x), 0.75, 1e-6);
}

TEST(Initialize, CoincidentAndFewPointsGiveFiniteScales) {
  const Threads threads(1);
  for (std::size_t n : {0u, 1u, 2u, 3u, 50u}) {
    PointCloud points;
    points.positions.assign(n, glm::vec3(1, 2, 3));
    points.colors.assign(n, glm::vec3(0.5f));
    const SplatCloud cloud = splats_from_points(points, 0.1, threads);
    for (std::size_t i = 0; i < n; ++i) EXPECT_TRUE(is_finite(cloud, i));
  }
}

TEST(Parameters, CloudAndBack) {
  const SplatCloud cloud = test::random_cloud(21, 2, 9);
  const SplatCloud back = to_cloud(to_parameters(cloud, 3), 3);
  ASSERT_EQ(back.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_EQ(back.positions[i], cloud.positions[i]);
    EXPECT_EQ(back.rotations[i], cloud.rotations[i]);
    for (std::size_t k = 0; k < 8; ++k)
      EXPECT_EQ(back.sh_rest[15 * i + k], cloud.sh_rest[8 * i + k]);
    for (std::size_t k = 8; k < 15; ++k) EXPECT_EQ(back.sh_rest[15 * i + k], glm::vec3(0));
  }
}

}  // namespace
}  // namespace fluxgs
