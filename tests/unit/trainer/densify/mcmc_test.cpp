// Densification as sampling.
#include "trainer/densify/mcmc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "support/scenes.h"
#include "trainer/densify/penalties.h"

namespace fluxgs {
namespace {

TrainState state_of(std::size_t n) {
  TrainState state;
  state.parameters = to_parameters(test::random_cloud(n, 1, 5), 1);
  state.adam = {PlanarFloats(state.parameters.rows(), n), PlanarFloats(state.parameters.rows(), n)};
  for (int r = 0; r < state.parameters.rows(); ++r)
    for (std::size_t i = 0; i < n; ++i) state.adam.first.row(r)[i] = 1;
  state.statistics = PlanarFloats(statistic::count, n);
  return state;
}

/// What a ray through the middle of `copies` equal splats in one place sees, integrated across: the
/// one-dimensional profile of their alpha, as the method's equation 9 conserves it.
double profile(double opacity, double scale, int copies) {
  double total = 0;
  for (double x = -8; x <= 8; x += 1e-3)
    total += 1 - std::pow(1 - opacity * std::exp(-0.5 * x * x / (scale * scale)), copies);
  return total * 1e-3;
}

TEST(Mcmc, CopiesTogetherLookLikeTheOne) {
  for (double opacity : {0.05, 0.5, 0.95})
    for (int copies : {1, 2, 5, 20}) {
      const Shared s = shared_among(opacity, copies);
      EXPECT_NEAR(1 - std::pow(1 - s.opacity, copies), opacity, 1e-12);
      EXPECT_NEAR(profile(s.opacity, s.scale, copies) / profile(opacity, 1, 1), 1, 2e-3)
          << opacity << " " << copies;
    }
  EXPECT_NEAR(shared_among(0.3, 1).scale, 1, 1e-12);
}

TEST(Mcmc, DeadSplatsMoveToLivingOnes) {
  TrainOptions options;
  options.get<DensificationOptions>().mcmc_growth = 0;
  TrainState state = state_of(40);
  for (std::size_t i = 0; i < 10; ++i) state.parameters.row(row::opacity)[i] = -8;
  const PlanarFloats before = state.parameters;
  const DensifyCounts counts = relocate_and_grow(state, options);
  EXPECT_EQ(counts.pruned, 10u);
  EXPECT_EQ(counts.cloned, 0u);
  ASSERT_EQ(state.parameters.size(), 40u);
  for (std::size_t i = 0; i < 10; ++i) {
    std::size_t source = 0;
    for (std::size_t j = 10; j < 40; ++j)
      if (before.row(row::position)[j] == state.parameters.row(row::position)[i]) source = j;
    ASSERT_GE(source, 10u) << "splat " << i << " lies where none was";
    EXPECT_EQ(state.parameters.row(row::opacity)[i], state.parameters.row(row::opacity)[source]);
    EXPECT_LT(state.parameters.row(row::opacity)[i], before.row(row::opacity)[source]);
    EXPECT_EQ(state.adam.first.row(row::position)[i], 0);
    EXPECT_EQ(state.adam.first.row(row::position)[source], 0);
  }
}

TEST(Mcmc, GrowsToTheTargetAndNoFurther) {
  TrainOptions options;
  options.target_splats = 107;
  TrainState state = state_of(100);
  EXPECT_EQ(relocate_and_grow(state, options).cloned, 5u);
  EXPECT_EQ(relocate_and_grow(state, options).cloned, 2u);
  EXPECT_EQ(relocate_and_grow(state, options).cloned, 0u);
  EXPECT_EQ(state.statistics.size(), 107u);
  EXPECT_EQ(state.adam.second.size(), 107u);
  options.target_splats = 200;
  options.max_splats = 110;  // such as memory sets
  EXPECT_EQ(relocate_and_grow(state, options).cloned, 3u);
}

TEST(Mcmc, NoiseMovesLowOpacitySplatsOnlyAndWhateverTheThreads) {
  const TrainOptions options;
  TrainState a = state_of(5000), b;
  for (std::size_t i = 0; i < 5000; ++i)
    a.parameters.row(row::opacity)[i] = i % 2 == 0 ? -6.0f : 2.0f;
  b = a;
  const PlanarFloats before = a.parameters;
  add_noise(a, options.get<DensificationOptions>(), 1e-4, Threads(1));
  add_noise(b, options.get<DensificationOptions>(), 1e-4, Threads(3));
  EXPECT_EQ(0, std::memcmp(a.parameters.row(0), b.parameters.row(0), 5000 * sizeof(float)));
  double moved = 0;
  for (std::size_t i = 0; i < 5000; ++i) {
    const double d = std::abs(double{a.parameters.row(0)[i]} - double{before.row(0)[i]});
    if (i % 2 == 1) {
      ASSERT_EQ(d, 0);
    }
    moved += d;
  }
  EXPECT_GT(moved, 0);
}

TEST(Mcmc, PenaltiesPullOpacityAndSizeDown) {
  TrainState state = state_of(20);
  PlanarFloats gradient(state.parameters.rows(), 20);
  std::vector<std::uint8_t> visible(48, 1);
  visible[3] = 0;
  TrainOptions options;
  options.get<PenaltyOptions>().opacity_weight = 0.2;
  options.get<PenaltyOptions>().scale_weight = 0.3;
  add_penalties(state.parameters, visible, options.get<PenaltyOptions>(), gradient, Threads(2));
  const auto mean = [&](std::size_t i, float opacity, float scale) {
    const double o = 1 / (1 + std::exp(-double{opacity}));
    (void)i;
    return 0.2 * o / 20 + 0.3 * std::exp(double{scale}) / 60;
  };
  for (std::size_t i : {0u, 7u}) {  // against differences
    const float o = state.parameters.row(row::opacity)[i],
                s = state.parameters.row(row::log_scale + 1)[i];
    EXPECT_NEAR(gradient.row(row::opacity)[i],
                (mean(i, o + 0.01f, s) - mean(i, o - 0.01f, s)) / 0.02, 1e-5);
    EXPECT_NEAR(gradient.row(row::log_scale + 1)[i],
                (mean(i, o, s + 0.01f) - mean(i, o, s - 0.01f)) / 0.02, 1e-5);
  }
  EXPECT_EQ(gradient.row(row::opacity)[3], 0);
}

}  // namespace
}  // namespace fluxgs
