// Adam, density control and the first splats.
#include <gtest/gtest.h>

#include <cmath>

#include "fluxgs/math/spherical_harmonics.h"
#include "support/scenes.h"
#include "trainer/densify/density_control.h"
#include "trainer/model/adam.h"
#include "trainer/model/initialize.h"
#include "trainer/options/options.h"

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
    adam_step(p, state, gradient, visible, rates, constants, step, 1, threads,
              adam_kernels(GetParam()));

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

/// A state of `n` splats with the given mean gradients and scales.
TrainState state_of(const std::vector<float>& gradients, const std::vector<float>& scales) {
  const std::size_t n = gradients.size();
  TrainState state;
  SplatCloud cloud = test::random_cloud(n, 0, 3);
  for (std::size_t i = 0; i < n; ++i) {
    cloud.log_scales[i] = glm::vec3(std::log(scales[i]));
    cloud.opacity_logits[i] = 0;
  }
  state.parameters = to_parameters(cloud, 0);
  state.adam = {PlanarFloats(state.parameters.rows(), n), PlanarFloats(state.parameters.rows(), n)};
  state.statistics = PlanarFloats(statistic::count, n);
  for (std::size_t i = 0; i < n; ++i) {
    state.statistics.row(statistic::gradient_sum)[i] = 4 * gradients[i];
    state.statistics.row(statistic::views)[i] = 4;
    for (int r = 0; r < state.parameters.rows(); ++r)
      state.adam.first.row(r)[i] = static_cast<float>(i + 1);
  }
  state.iteration = 600;
  return state;
}

TEST(Densify, ClonesSmallSplitsLargeKeepsTheRest) {
  const TrainOptions options;  // gradient 2e-4; size 0.01 of the extent
  TrainState state = state_of({1e-3f, 1e-3f, 1e-5f}, {0.005f, 0.05f, 0.005f});
  const PlanarFloats before = state.parameters;
  const DensifyCounts counts = densify_and_prune(state, options, 1.0, nullptr);
  EXPECT_EQ(counts.cloned, 1u);
  EXPECT_EQ(counts.split, 1u);
  EXPECT_EQ(counts.pruned, 0u);
  // Splats 0 and 2 stay, then the clone of 0, then the halves of 1
  ASSERT_EQ(state.parameters.size(), 5u);
  for (int r = 0; r < before.rows(); ++r) {
    EXPECT_EQ(state.parameters.row(r)[0], before.row(r)[0]);
    EXPECT_EQ(state.parameters.row(r)[1], before.row(r)[2]);
    EXPECT_EQ(state.parameters.row(r)[2], before.row(r)[0]);
    EXPECT_EQ(state.adam.first.row(r)[0], 1);
    EXPECT_EQ(state.adam.first.row(r)[1], 3);
    for (std::size_t i = 2; i < 5; ++i) EXPECT_EQ(state.adam.first.row(r)[i], 0);
  }
  for (std::size_t half : {3u, 4u}) {
    EXPECT_NEAR(state.parameters.row(row::log_scale)[half], std::log(0.05 / 1.6), 1e-5);
    double distance = 0;
    for (int c = 0; c < 3; ++c)
      distance += std::pow(
          state.parameters.row(row::position + c)[half] - before.row(row::position + c)[1], 2);
    EXPECT_GT(distance, 0);
    EXPECT_LT(std::sqrt(distance), 0.05 * 6);
    EXPECT_EQ(state.parameters.row(row::sh_dc)[half], before.row(row::sh_dc)[1]);
  }
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(state.statistics.row(statistic::views)[i], 0);
}

TEST(Densify, PrunesTransparentAndOversizedSplats) {
  TrainOptions options;
  options.prune_screen_radius = 20;
  TrainState state = state_of({0, 0, 0, 0}, {0.01f, 0.01f, 0.2f, 0.01f});
  state.parameters.row(row::opacity)[1] = -6;        // sigmoid(−6) = 0.0025 < 0.005
  state.statistics.row(statistic::radius)[3] = 21;   // > 20 px
  state.iteration = options.opacity_reset_interval;  // sizes do not count yet
  TrainState later = state, any_radius = state;
  EXPECT_EQ(densify_and_prune(state, options, 1.0, nullptr).pruned, 1u);
  later.iteration = options.opacity_reset_interval + 1;
  EXPECT_EQ(densify_and_prune(later, options, 1.0, nullptr).pruned, 3u);
  EXPECT_EQ(later.parameters.size(), 1u);
  any_radius.iteration = options.opacity_reset_interval + 1;
  options.prune_screen_radius = 0;
  EXPECT_EQ(densify_and_prune(any_radius, options, 1.0, nullptr).pruned, 2u);
}

TEST(Densify, NeverExceedsTheLimitAndPrefersLargeGradients) {
  TrainOptions options;
  options.max_splats = 5;
  TrainState state = state_of({1e-3f, 5e-3f, 2e-3f, 3e-4f}, {0.005f, 0.005f, 0.005f, 0.005f});
  const float wanted = state.parameters.row(row::position)[1];
  EXPECT_EQ(densify_and_prune(state, options, 1.0, nullptr).cloned, 1u);
  ASSERT_EQ(state.parameters.size(), 5u);
  EXPECT_EQ(state.parameters.row(row::position)[4], wanted);
  EXPECT_EQ(densify_and_prune(state, options, 1.0, nullptr).cloned, 0u);
}

TEST(Densify, ResetLimitsOpacity) {
  TrainState state = state_of({0, 0}, {1, 1});
  state.parameters.row(row::opacity)[1] = -8;
  reset_opacity(state, TrainOptions{});
  EXPECT_NEAR(state.parameters.row(row::opacity)[0], std::log(0.01 / 0.99), 1e-5);
  EXPECT_EQ(state.parameters.row(row::opacity)[1], -8);
  EXPECT_EQ(state.adam.first.row(row::opacity)[0], 0);
  EXPECT_EQ(state.adam.first.row(row::position)[0], 1);
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

TEST(TrainOptionsTest, RangesAreCheckedByName) {
  TrainOptions options;
  EXPECT_TRUE(validate(options));
  options.lambda_dssim = 1.5;
  const auto result = validate(options);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message().find("--lambda-dssim: 1.5 is out of range, expected 0 to 1"),
            std::string::npos);
  options.lambda_dssim = std::nan("");
  EXPECT_FALSE(validate(options));
  EXPECT_FALSE(preset("no-such"));
  EXPECT_TRUE(preset("3dgs"));
}

}  // namespace
}  // namespace fluxgs
