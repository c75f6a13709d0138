#include "trainer/densify/dropout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

double sigmoid(double logit) { return 1 / (1 + std::exp(-logit)); }

PlanarFloats splats_with(const std::vector<float>& logits) {
  PlanarFloats p(row::count(0), logits.size());
  for (std::size_t i = 0; i < logits.size(); ++i) p.row(row::opacity)[i] = logits[i];
  return p;
}

TEST(Dropout, GrowsWithTheRunAndFallsWithTheNumberOfViews) {
  EXPECT_EQ(dropout_share(DropoutOptions().dropout, 14, 1000, 1000), 0);  // off unless asked for
  EXPECT_EQ(dropout_share(2, 100, 0, 1000), 0);
  EXPECT_NEAR(dropout_share(2, 100, 500, 1000), 0.01, 1e-12);
  EXPECT_NEAR(dropout_share(2, 100, 1000, 1000), 0.02, 1e-12);
  EXPECT_NEAR(dropout_share(2, 1, 1000, 1000), 0.2, 1e-12);
  EXPECT_NEAR(dropout_share(2, 0, 1000, 1000), 0.2, 1e-12);
}

TEST(Dropout, KeepsTheMeanOpacityAndGivesItBackExactly) {
  const std::vector<float> logits(20000, 0.3f);
  PlanarFloats p = splats_with(logits);
  PlanarFloats gradient = splats_with(std::vector<float>(logits.size(), 1));
  Random random(7);
  const std::vector<float> true_logits = hide_splats(p, 0.2, random);
  double sum = 0;
  std::size_t hidden = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) {
    const double opacity = sigmoid(double{p.row(row::opacity)[i]});
    sum += opacity;
    hidden += opacity < 1.0 / 255;
  }
  const auto n = static_cast<double>(logits.size());
  EXPECT_NEAR(static_cast<double>(hidden) / n, 0.2, 0.01);
  EXPECT_NEAR(sum / n, sigmoid(0.3), 0.01);
  restore_splats(p, true_logits, gradient.row(row::opacity));
  for (std::size_t i = 0; i < logits.size(); ++i) ASSERT_EQ(p.row(row::opacity)[i], logits[i]);
}

TEST(Dropout, TurnsGradientsIntoThoseOfTheTrueOpacity) {
  const std::vector<float> logits = {-6, -1, 0, 1};
  constexpr double kShare = 0.15;
  PlanarFloats p = splats_with(logits), gradient = splats_with({0, 0, 0, 0});
  Random random(2);
  const std::vector<float> true_logits = hide_splats(p, kShare, random);
  std::vector<double> expected(logits.size());
  for (std::size_t i = 0; i < logits.size(); ++i) {
    const double shown = sigmoid(double{p.row(row::opacity)[i]});
    ASSERT_GT(shown, 0.001) << "of this seed no splat is to be hidden";
    // The rasteriser's derivative of f(o′) = o′² by the altered logit, against differences by the
    // true one
    gradient.row(row::opacity)[i] = static_cast<float>(2 * shown * shown * (1 - shown));
    const auto f = [&](double logit) { return std::pow(sigmoid(logit) / (1 - kShare), 2); };
    const double l = double{logits[i]};
    expected[i] = (f(l + 1e-4) - f(l - 1e-4)) / 2e-4;
  }
  restore_splats(p, true_logits, gradient.row(row::opacity));
  for (std::size_t i = 0; i < logits.size(); ++i)
    EXPECT_NEAR(double{gradient.row(row::opacity)[i]}, expected[i], 2e-5 * expected[i] + 1e-9);
}

TEST(Dropout, OpaqueAndTransparentSplatsStayFinite) {
  const float huge = std::numeric_limits<float>::max();
  const std::vector<float> logits = {40, 4.5f, -90, -huge, huge};
  PlanarFloats p = splats_with(logits), gradient = splats_with({1, 1, 1, 1, 1});
  for (int seed = 0; seed < 20; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const std::vector<float> true_logits = hide_splats(p, 0.2, random);
    for (std::size_t i = 0; i < logits.size(); ++i)
      EXPECT_FALSE(std::isnan(p.row(row::opacity)[i]));
    restore_splats(p, true_logits, gradient.row(row::opacity));
    for (std::size_t i = 0; i < logits.size(); ++i) {
      EXPECT_EQ(p.row(row::opacity)[i], logits[i]);
      EXPECT_TRUE(std::isfinite(gradient.row(row::opacity)[i])) << i;
      gradient.row(row::opacity)[i] = 1;
    }
  }
}

TEST(Dropout, TrainsTheSameSceneOnAnyNumberOfThreads) {
  const Dataset& data = test::small_capture();
  TrainOptions options = test::short_run(60);
  const auto end = [&](int threads) {
    return test::train(data, options, test::fresh(data, options), threads, 60);
  };
  const TrainState without = end(1);
  options.get<DropoutOptions>().dropout = 2;
  const TrainState one = end(1);
  test::expect_same(one, end(2));
  EXPECT_NE(one.random, without.random);
  EXPECT_NE(one.parameters.row(row::sh_dc)[0], without.parameters.row(row::sh_dc)[0]);
}

}  // namespace
}  // namespace fluxgs
