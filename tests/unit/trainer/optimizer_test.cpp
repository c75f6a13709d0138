// Adam, the first splats and the options.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fluxgs/math/spherical_harmonics.h"
#include "support/scenes.h"
#include "trainer/core/adam.h"
#include "trainer/model/initialize.h"
#include "trainer/model/options.h"

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

TEST(TrainOptionsTest, PresetsAreValidAndUnknownOnesNamed) {
  EXPECT_EQ(preset_names(), (std::vector<std::string>{"flux", "flux-paper", "3dgs", "3dgs-sh1"}));
  for (const std::string& name : preset_names()) {
    const auto options = preset(name);
    ASSERT_TRUE(options) << name;
    EXPECT_TRUE(validate(*options)) << name;
  }
  const auto unknown = preset("4dgs");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message().find("3dgs-sh1"), std::string::npos);
}

/// Sets a choice by its name, as the command line does.
TrainOptions chosen(const std::string& option, std::string_view name) {
  TrainOptions options;
  for (const OptionField& f : option_fields()) {
    if (f.name != option) continue;
    const auto at = std::ranges::find(f.choice.names, name);
    EXPECT_NE(at, f.choice.names.end()) << option << " " << name;
    if (at != f.choice.names.end())
      f.choice.set(options, static_cast<int>(at - f.choice.names.begin()));
  }
  return options;
}

TEST(TrainOptionsTest, ChoicesHaveTheirNames) {
  EXPECT_EQ(chosen("sh-target", "0").sh_target, ShTarget::degree_0);
  EXPECT_EQ(chosen("sh-target", "2").sh_target, ShTarget::degree_2);
  EXPECT_EQ(chosen("sh-target", "adaptive").sh_target, ShTarget::adaptive);
  EXPECT_EQ(chosen("sh-reduce", "view-ls").sh_reduce, ShReduction::view_ls);
  EXPECT_EQ(chosen("sh-reduce", "truncate").sh_reduce, ShReduction::truncate);
  EXPECT_EQ(chosen("sh-reduce", "uniform-ls").sh_reduce, ShReduction::uniform_ls);
  EXPECT_EQ(chosen("sh-reduce", "energy").sh_reduce, ShReduction::energy);
  EXPECT_EQ(chosen("sh-reduce", "none").sh_reduce, ShReduction::none);
  EXPECT_EQ(chosen("residual", "3-2").residual, Residual::from_2);
  EXPECT_EQ(chosen("residual", "3-0").residual, Residual::from_0);
  EXPECT_EQ(chosen("quadrature", "lebedev").quadrature, Quadrature::lebedev);
  EXPECT_EQ(chosen("quadrature", "mc").quadrature, Quadrature::mc);
  EXPECT_EQ(chosen("psi", "off").psi, Switch::off);
  EXPECT_EQ(chosen("phi", "on").phi, Switch::on);
  EXPECT_EQ(chosen("densify", "grad").densify, Densify::grad);
  EXPECT_EQ(chosen("densify", "multiview").densify, Densify::multiview);
  EXPECT_EQ(chosen("densify", "mcmc").densify, Densify::mcmc);
  EXPECT_EQ(chosen("split", "long-axis").split, Split::long_axis);
  EXPECT_EQ(chosen("growth-rank", "error").growth_rank, GrowthRank::error);
  EXPECT_EQ(chosen("camera-sampling", "random").camera_sampling, CameraSampling::random);
  EXPECT_EQ(chosen("score", "alpha-t").score_weight, ScoreWeight::alpha_transmittance);
  EXPECT_EQ(chosen("score-unit", "raw").score_unit, ScoreUnit::raw);
  EXPECT_EQ(chosen("score-share", "sum").score_share, ScoreShare::sum);
  EXPECT_EQ(chosen("prune", "none").prune, Prune::none);
  EXPECT_EQ(chosen("prune", "multiview").prune, Prune::multiview);
  EXPECT_EQ(chosen("late-prune", "opacity").late_prune, LatePrune::opacity);
  EXPECT_EQ(chosen("late-prune", "contribution").late_prune, LatePrune::contribution);
  EXPECT_EQ(chosen("rounding", "on").rounding, Switch::on);
}

TEST(TrainOptionsTest, RulesThatDoNotExistAreRefused) {
  TrainOptions options = preset("flux-paper").value();
  options.quadrature = Quadrature::lebedev;  // with the paper's 2,048 directions
  const auto valid = validate(options);
  ASSERT_FALSE(valid);
  EXPECT_NE(valid.error().message().find("--samples"), std::string::npos);
  options.samples = 302;
  EXPECT_TRUE(validate(options));
}

TEST(TrainOptionsTest, WhatDependsOnTheLengthFollowsIt) {
  TrainOptions options;
  options.iterations = 2000;
  const TrainOptions short_run = resolved(options);
  EXPECT_EQ(short_run.densify_until, 1000);
  EXPECT_EQ(short_run.switch_iteration, 200);
  EXPECT_EQ(short_run.sh_degree_interval, 251);
  options.sh_target = ShTarget::degree_1;
  EXPECT_EQ(resolved(options).sh_degree_interval, 50);  // degree 3 for a quarter of these 200
  options.iterations = 30000;
  EXPECT_EQ(resolved(options).switch_iteration, 3000);  // as in the paper
  options.sh_target = ShTarget::adaptive;
  EXPECT_EQ(resolved(options).switch_iteration, 21000);
}

TEST(TrainOptionsTest, WhatEndsWithTheRunFollowsItsLength) {
  for (const int iterations : {600, 3000, 7000, 30000}) {
    TrainOptions flux = preset("flux").value();
    flux.iterations = iterations;
    const TrainOptions o = resolved(flux);
    EXPECT_LT(o.densify_until, o.switch_iteration);
    EXPECT_LT(o.switch_iteration, o.round_from);
    EXPECT_LT(o.round_from, iterations);
    EXPECT_GE(o.densify_interval, 50);
  }
}

TEST(TrainOptionsTest, LatePruningByContributionDoesNotWaitForTheLastDensification) {
  TrainOptions o;
  o.late_prune = LatePrune::opacity;
  // At 18, 21, 24 and 27 thousand, as in the design of the paper
  EXPECT_EQ(resolved(o).late_prune_from, 18000);
  EXPECT_EQ(resolved(o).late_prune_until, 27000);
  EXPECT_EQ(resolved(o).late_prune_interval, 3000);
  o.late_prune = LatePrune::contribution;
  EXPECT_EQ(resolved(o).late_prune_from, 6000);
  EXPECT_EQ(resolved(o).late_prune_interval, 3000);
  EXPECT_EQ(resolved(o).late_prune_until, 20000);
}

TEST(TrainOptionsTest, RoundingTakesTheSameShareOfLongRuns) {
  TrainOptions o = preset("flux").value();
  for (const auto& [iterations, interval] : {std::pair(7000, 20), {30000, 30}, {45000, 45}}) {
    o.iterations = iterations;
    EXPECT_EQ(resolved(o).round_interval, interval);
  }
}

TEST(TrainOptionsTest, RoundingWaitsForWhatChangesTheScene) {
  TrainOptions o;
  o.iterations = 100;
  o.rounding = Switch::on;
  o.round_from = 10;
  o.densify_until = 60;
  EXPECT_EQ(resolved(o).round_from, 61);
  o.sh_target = ShTarget::adaptive;
  o.switch_iteration = 80;
  EXPECT_EQ(resolved(o).round_from, 81);
}

TEST(TrainOptionsTest, PartsThatNeedEachOtherAreCheckedByName) {
  const auto refused = [](const TrainOptions& o, const char* name) {
    const auto valid = validate(o);
    return !valid && valid.error().message().find(name) != std::string::npos;
  };
  TrainOptions o;
  o.phi = Switch::on;
  EXPECT_TRUE(refused(o, "--phi"));
  o.sh_target = ShTarget::degree_1;
  EXPECT_TRUE(validate(o));
  o.sh_degree = 0;
  EXPECT_TRUE(refused(o, "--phi"));
  o = {};
  o.sh_reduce = ShReduction::energy;
  EXPECT_TRUE(refused(o, "--sh-reduce"));
  o = {};
  o.sh_target = ShTarget::adaptive;
  o.sh_reduce = ShReduction::truncate;
  EXPECT_TRUE(refused(o, "--sh-target"));
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
