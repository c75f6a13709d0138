// Which splats grow, which go, and what becomes of them.
#include "trainer/densify/density_control.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/late_pruning.h"
#include "trainer/densify/opacity_reset.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"

namespace fluxgs {
namespace {

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
  options.get<DensificationOptions>().prune_screen_radius = 20;
  TrainState state = state_of({0, 0, 0, 0}, {0.01f, 0.01f, 0.2f, 0.01f});
  state.parameters.row(row::opacity)[1] = -6;                     // sigmoid(−6) = 0.0025 < 0.005
  state.statistics.row(statistic::radius)[3] = 21;                // > 20 px
  state.iteration = options.get<OpacityResetOptions>().interval;  // sizes do not count yet
  TrainState later = state, any_radius = state, any_size = state;
  EXPECT_EQ(densify_and_prune(state, options, 1.0, nullptr).pruned, 1u);
  later.iteration = options.get<OpacityResetOptions>().interval + 1;
  EXPECT_EQ(densify_and_prune(later, options, 1.0, nullptr).pruned, 3u);
  EXPECT_EQ(later.parameters.size(), 1u);
  any_radius.iteration = options.get<OpacityResetOptions>().interval + 1;
  options.get<DensificationOptions>().prune_screen_radius = 0;
  EXPECT_EQ(densify_and_prune(any_radius, options, 1.0, nullptr).pruned, 2u);
  any_size.iteration = options.get<OpacityResetOptions>().interval + 1;
  options.get<DensificationOptions>().prune_world_size = 0;
  EXPECT_EQ(densify_and_prune(any_size, options, 1.0, nullptr).pruned, 1u);
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
  reset_opacity(state, OpacityResetOptions().to);
  EXPECT_NEAR(state.parameters.row(row::opacity)[0], std::log(0.01 / 0.99), 1e-5);
  EXPECT_EQ(state.parameters.row(row::opacity)[1], -8);
  EXPECT_EQ(state.adam.first.row(row::opacity)[0], 0);
  EXPECT_EQ(state.adam.first.row(row::position)[0], 1);
}

/// Scores that say of every splat that it covers ten pixels.
SplatScores scores_of(std::vector<float> plus, std::vector<float> minus,
                      std::vector<float> contribution) {
  const std::size_t n = plus.size();
  return {std::move(plus), std::move(minus), std::move(contribution), std::vector<float>(n, 10.0f)};
}

TEST(Densify, GrowsOnlyWhereSeveralViewsSeeErrors) {
  TrainOptions options;
  options.get<DensificationOptions>().strategy = Densify::multiview;
  options.get<ScoreOptions>().quantile_plus = 0.5;
  TrainState state = state_of({1e-3f, 1e-3f, 1e-3f, 1e-5f}, {0.005f, 0.005f, 0.005f, 0.005f});
  const float wanted = state.parameters.row(row::position)[2];
  const SplatScores scores = scores_of({0.1f, 0.2f, 0.9f, 0.8f}, {0, 0, 0, 0}, {1, 1, 1, 1});
  const DensifyCounts counts = densify_and_prune(state, options, 1.0, &scores);
  // The median is 0.2: 2 and 3 are above it, and of these 2 has a large gradient
  EXPECT_EQ(counts.cloned, 1u);
  ASSERT_EQ(state.parameters.size(), 5u);
  EXPECT_EQ(state.parameters.row(row::position)[4], wanted);
}

TEST(Densify, GrowthByGradientsIgnoresTheScoresThatPruningHas) {
  TrainOptions options;
  options.get<DensificationOptions>().strategy = Densify::gradient;
  options.get<DensificationOptions>().prune = Prune::multiview;
  options.get<ScoreOptions>().quantile_plus = 0.5;
  TrainState state = state_of({1e-3f, 1e-3f, 1e-5f}, {0.005f, 0.005f, 0.005f});
  const SplatScores scores = scores_of({0.1f, 0.2f, 0.9f}, {0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(densify_and_prune(state, options, 1.0, &scores).cloned, 2u);
}

TEST(Densify, SmallerGradientsSufficeWhereLessLossIsLeft) {
  TrainOptions options;
  auto& own = options.get<DensificationOptions>();
  own.strategy = Densify::multiview;
  own.gradient = 1e-3;
  own.loss = 0.04;
  options.get<ScoreOptions>().quantile_plus = 0;
  const auto grown = [&](double loss) {
    TrainState state = state_of({0.4e-3f, 0.7e-3f, 0.9e-3f, 1.1e-3f, 2e-3f},
                                {0.005f, 0.005f, 0.005f, 0.005f, 0.005f});
    SplatScores scores = scores_of({1, 1, 1, 1, 1}, {0, 0, 0, 0, 0}, {1, 1, 1, 1, 1});
    scores.plus[0] = 0.5f;
    scores.loss = loss;
    return densify_and_prune(state, options, 1.0, &scores).cloned;
  };
  EXPECT_EQ(grown(0.04), 2u);
  EXPECT_EQ(grown(0.02), 3u);  // from 0.81e-3 on
  EXPECT_EQ(grown(0.01), 4u);  // 0.66e-3
  EXPECT_EQ(grown(0.08), 1u);  // 1.23e-3
  EXPECT_EQ(grown(0), 4u);     // 0.54e-3: a perfect scene does not grow everywhere
  own.loss = 0;
  EXPECT_EQ(grown(0.01), 2u);
}

TEST(Densify, SmallerGradientsSufficeWhereRemovedSplatsWereWorthMuch) {
  TrainOptions options;
  auto& own = options.get<DensificationOptions>();
  own.gradient = 1e-3;
  own.worth = 8;
  const auto grown = [&](double worth) {
    TrainState state = state_of({0.3e-3f, 0.5e-3f, 0.7e-3f, 0.9e-3f, 2e-3f},
                                {0.005f, 0.005f, 0.005f, 0.005f, 0.005f});
    state.splat_worth = worth;
    return densify_and_prune(state, options, 1.0, nullptr).cloned;
  };
  EXPECT_EQ(grown(0), 1u);   // not yet measured
  EXPECT_EQ(grown(-3), 1u);  // better without them
  EXPECT_EQ(grown(8), 1u);
  EXPECT_EQ(grown(10), 2u);   // from 0.8e-3 on
  EXPECT_EQ(grown(12), 3u);   // 0.67e-3
  EXPECT_EQ(grown(20), 3u);   // 0.58e-3
  EXPECT_EQ(grown(1e9), 3u);  // the same: a perfect scene does not grow everywhere
  own.worth = 0;
  EXPECT_EQ(grown(20), 1u);
}

TEST(Densify, UnseenSplatsDoNotCountInQuantiles) {
  SplatScores scores = scores_of({0, 0, 0, 1, 2, 3}, {0, 0, 0, 0, 0, 0}, {0, 0, 0, 1, 1, 1});
  for (std::size_t i = 0; i < 3; ++i) scores.pixels[i] = 0;
  EXPECT_EQ(score_quantile(scores.plus, scores, 0.5, ScoreNormalization::pixel), 2);
  EXPECT_EQ(score_quantile(scores.plus, scores, 0.5, ScoreNormalization::sum), 0);
  const SplatScores none;
  EXPECT_EQ(score_quantile(none.plus, none, 0.5, ScoreNormalization::pixel), -1);
}

TEST(Densify, ModeratePruningSparesWhatHasNoPartInGoodPixels) {
  TrainOptions options;
  options.get<DensificationOptions>().prune = Prune::multiview;
  options.get<ScoreOptions>().quantile_minus = 0.5;
  TrainState state = state_of({0, 0, 0}, {0.005f, 0.005f, 0.005f});
  for (std::size_t i = 0; i < 2; ++i) state.parameters.row(row::opacity)[i] = -6;
  const float kept = state.parameters.row(row::position)[0];
  const SplatScores scores = scores_of({0, 0, 0}, {0.1f, 0.9f, 0.2f}, {1, 1, 1});
  EXPECT_EQ(densify_and_prune(state, options, 1.0, &scores).pruned, 1u);
  EXPECT_EQ(state.parameters.row(row::position)[0], kept);
  options.get<DensificationOptions>().prune = Prune::none;
  EXPECT_EQ(densify_and_prune(state, options, 1.0, nullptr).pruned, 0u);
}

TEST(Densify, ATargetIsReachedInEqualSteps) {
  TrainOptions options;
  options.get<DensificationOptions>().from = 100,
  options.get<DensificationOptions>().interval = 100,
  options.get<DensificationOptions>().until = 300;
  options.target_splats = 16;
  TrainState state = state_of(std::vector<float>(10, 1e-9f), std::vector<float>(10, 0.005f));
  for (std::size_t expected : {12u, 14u, 16u, 16u}) {
    state.iteration = static_cast<int>(100 + 100 * (expected - 12) / 2);
    densify_and_prune(state, options, 1.0, nullptr);
    EXPECT_EQ(state.parameters.size(), expected);
    if (expected == 16) state.iteration = 300;
  }
}

TEST(Densify, WhatIsPrunedAtLastIsMadeUpForByATarget) {
  TrainOptions options;
  options.get<DensificationOptions>().from = options.get<DensificationOptions>().until =
      options.get<DensificationOptions>().interval = 100;
  options.target_splats = 10;
  std::vector<float> gradients(8, 1e-9f);
  gradients[0] = gradients[1] = 1;  // would be the first to grow if they stayed
  TrainState state = state_of(gradients, std::vector<float>(8, 0.005f));
  state.iteration = 100;
  for (std::size_t i = 0; i < 2; ++i) state.parameters.row(row::opacity)[i] = -9;
  EXPECT_EQ(densify_and_prune(state, options, 1.0, nullptr).pruned, 2u);
  EXPECT_EQ(state.parameters.size(), 10u);
}

TEST(Densify, GrowthIsLimitedAndTheRankDecides) {
  TrainOptions options;
  options.get<DensificationOptions>().strategy = Densify::multiview;
  options.get<DensificationOptions>().growth = 0.25;
  options.get<ScoreOptions>().quantile_plus = 0;
  options.get<DensificationOptions>().growth_rank = GrowthRank::error;
  TrainState state = state_of({1e-3f, 2e-3f, 3e-3f, 4e-3f}, std::vector<float>(4, 0.005f));
  TrainState same = state;
  const float by_error = state.parameters.row(row::position)[1],
              by_gradient = state.parameters.row(row::position)[3];
  const SplatScores scores = scores_of({0.1f, 0.9f, 0.2f, 0.3f}, {0, 0, 0, 0}, {1, 1, 1, 1});
  EXPECT_EQ(densify_and_prune(state, options, 1.0, &scores).cloned, 1u);
  EXPECT_EQ(state.parameters.row(row::position)[4], by_error);
  options.get<DensificationOptions>().growth_rank = GrowthRank::gradient;
  densify_and_prune(same, options, 1.0, &scores);
  EXPECT_EQ(same.parameters.row(row::position)[4], by_gradient);
}

TEST(Densify, LongAxisSplitsLieSideBySide) {
  TrainOptions options;
  options.get<DensificationOptions>().split = Split::long_axis;
  TrainState state = state_of({1e-3f}, {0.02f});
  PlanarFloats& p = state.parameters;
  p.row(row::log_scale + 1)[0] = std::log(0.2f);
  for (int c = 0; c < 4; ++c) p.row(row::rotation + c)[0] = c == 0 ? 2.0f : 0.0f;
  const PlanarFloats before = p;
  EXPECT_EQ(densify_and_prune(state, options, 1.0, nullptr).split, 1u);
  ASSERT_EQ(p.size(), 2u);
  for (std::size_t half : {0u, 1u}) {
    const double side = half == 0 ? 1 : -1;
    EXPECT_NEAR(p.row(row::position + 1)[half], before.row(row::position + 1)[0] + side * 0.15,
                1e-6);
    EXPECT_EQ(p.row(row::position)[half], before.row(row::position)[0]);
    EXPECT_NEAR(std::exp(p.row(row::log_scale + 1)[half]), 0.1, 1e-6);
    EXPECT_NEAR(std::exp(p.row(row::log_scale)[half]), 0.02 * 0.85, 1e-6);
    EXPECT_NEAR(p.row(row::opacity)[half], std::log(0.3 / 0.7), 1e-5);
  }
}

TEST(Densify, OpacitiesAreCapped) {
  TrainOptions options;
  options.get<DensificationOptions>().opacity_cap = 0.8;
  TrainState state = state_of({0, 0}, {0.005f, 0.005f});
  state.parameters.row(row::opacity)[0] = 5;
  densify_and_prune(state, options, 1.0, nullptr);
  EXPECT_NEAR(state.parameters.row(row::opacity)[0], std::log(0.8 / 0.2), 1e-5);
  EXPECT_EQ(state.parameters.row(row::opacity)[1], 0);
}

TEST(LatePrune, RemovesTransparentSplatsOfGoodPixels) {
  TrainOptions options;
  options.get<LatePruningOptions>().mode = LatePrune::opacity;
  options.get<ScoreOptions>().quantile_minus = 0.25;
  TrainState state = state_of({0, 0, 0, 0}, std::vector<float>(4, 0.005f));
  for (std::size_t i = 0; i < 3; ++i) state.parameters.row(row::opacity)[i] = -3;  // 0.047 < 0.1
  TrainState target = state;
  const SplatScores scores = scores_of({0, 0, 0, 0}, {0.1f, 0.9f, 0.8f, 0.7f}, {1, 1, 1, 1});
  EXPECT_EQ(prune_late(state, options, scores).pruned, 2u);
  options.target_splats = 3;  // never below
  EXPECT_EQ(prune_late(target, options, scores).pruned, 1u);
}

// What is too low-opacity to be drawn covers no pixel and has no score.
TEST(LatePrune, RemovesWhatIsNotDrawn) {
  TrainOptions options;
  options.get<LatePruningOptions>().mode = LatePrune::opacity;
  TrainState state = state_of({0, 0}, std::vector<float>(2, 0.005f));
  state.parameters.row(row::opacity)[0] = -6;  // 0.0025 < 1/255
  const float stays = state.parameters.row(row::position)[1];
  const SplatScores scores = scores_of({0, 0}, {0, 0.5f}, {0, 1});
  EXPECT_EQ(prune_late(state, options, scores).pruned, 1u);
  ASSERT_EQ(state.parameters.size(), 1u);
  EXPECT_EQ(state.parameters.row(row::position)[0], stays);
}

TEST(LatePrune, RemovesTheLeastPartOfTheImages) {
  TrainOptions options;
  options.get<LatePruningOptions>().mode = LatePrune::contribution;
  options.get<LatePruningOptions>().share = 0.1;
  TrainState state = state_of({0, 0, 0, 0}, std::vector<float>(4, 0.005f));
  const float last = state.parameters.row(row::position)[3];
  // Of 100 in all, 4 + 5 may go, the next would be too much
  const SplatScores scores = scores_of({0, 0, 0, 0}, {0, 0, 0, 0}, {5, 4, 21, 70});
  EXPECT_EQ(prune_late(state, options, scores).pruned, 2u);
  ASSERT_EQ(state.parameters.size(), 2u);
  EXPECT_EQ(state.parameters.row(row::position)[1], last);
}

TEST(LatePrune, ManyPixelsForLittleGoFirst) {
  TrainOptions options;
  options.get<LatePruningOptions>().mode = LatePrune::contribution;
  options.get<LatePruningOptions>().share = 0.06;
  TrainState state = state_of({0, 0, 0, 0}, std::vector<float>(4, 0.005f));
  const float small = state.parameters.row(row::position)[0];
  // Of 100 in all, 6 may go: 4, or 5 that cost more than others
  SplatScores scores = scores_of({0, 0, 0, 0}, {0, 0, 0, 0}, {4, 5, 21, 70});
  scores.pixels = {10, 1000, 10, 10};
  EXPECT_EQ(prune_late(state, options, scores).pruned, 1u);
  EXPECT_EQ(state.parameters.row(row::position)[0], small);
}

TEST(LatePrune, RemovesWhatNobodySees) {
  TrainOptions options;
  options.get<LatePruningOptions>().mode = LatePrune::contribution;
  TrainState state = state_of({0, 0, 0}, std::vector<float>(3, 0.005f));
  SplatScores scores = scores_of({0, 0, 0}, {0, 0, 0}, {0, 1, 0});
  scores.pixels = {0, 3, 0};
  EXPECT_EQ(prune_late(state, options, scores).pruned, 2u);
}

TEST(LatePrune, WhatOnlyOtherViewsMaySeeStays) {
  TrainOptions options;
  options.get<LatePruningOptions>().mode = LatePrune::contribution;
  options.get<LatePruningOptions>().share = 0.1;
  TrainState state = state_of({0, 0, 0}, std::vector<float>(3, 0.005f));
  const float unseen = state.parameters.row(row::position)[0];
  SplatScores scores = scores_of({0, 0, 0}, {0, 0, 0}, {0, 95, 5});
  scores.pixels = {0, 3, 3};
  scores.sampled = true;
  EXPECT_EQ(prune_late(state, options, scores).pruned, 1u);
  ASSERT_EQ(state.parameters.size(), 2u);
  EXPECT_EQ(state.parameters.row(row::position)[0], unseen);
}

TEST(LatePrune, LooksAtAsManyViewsAsARunOfThatLengthAffords) {
  const auto views = [](int iterations, int asked) {
    TrainOptions options;
    options.iterations = iterations;
    options.get<LatePruningOptions>().mode = LatePrune::contribution;
    options.get<LatePruningOptions>().views = asked;
    make_late_pruning(options, iterations / 2);
    return options.get<LatePruningOptions>().views;
  };
  EXPECT_EQ(views(1000, 0), 40);
  EXPECT_EQ(views(7000, 0), 70);  // 5 times 70, one and a half renders each: a twentieth of 7,000
  EXPECT_EQ(views(30000, 0), 300);
  EXPECT_EQ(views(30000, 7), 7);
}

}  // namespace
}  // namespace fluxgs
