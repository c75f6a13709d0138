// SH reduction and network colours within a run.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "fluxgs/io/gltf.h"
#include "support/needs_onnxruntime.h"
#include "trainer/compress/compression.h"
#include "trainer/compress/sh_reduction.h"
#include "trainer/paper/energy_moments.h"
#include "trainer/train/evaluate.h"
#include "trainer/train/store_scene.h"
#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

/// A run, with its reports of phases.
struct Told {
  TrainState state;
  std::optional<PhaseReport> reduced;
  SplatCloud cloud;
  std::optional<StoredScene> stored;
};

Told run(const TrainOptions& options) {
  const Dataset& data = small_capture();
  const Threads threads(2);
  Profiler times;
  Trainer trainer(data, options, fresh(data, options), threads, times);
  Told told;
  while (!trainer.done()) {
    for (const PhaseReport& report : trainer.step().phases)
      if (report.name == "SH reduction") told.reduced = report;
  }
  told.state = trainer.saved_state();
  told.cloud = trainer.cloud();
  auto stored = store_scene(trainer, data.train, threads, {});
  EXPECT_TRUE(stored) << stored.error().message();
  if (stored) told.stored = std::move(*stored);
  return told;
}

TEST(Events, AreShownFromBeginningToEnd) {
  const Dataset& data = small_capture();
  const Threads threads(2);
  TrainOptions options = short_run(40);
  options.get<ShReductionOptions>().target = ShTarget::adaptive;
  options.get<ShReductionOptions>().iteration = 30;
  Profiler times;
  Trainer trainer(data, options, fresh(data, options), threads, times);
  while (trainer.event_at(trainer.state.iteration + 1) == nullptr) trainer.step();
  EXPECT_EQ(trainer.state.iteration, 29);
  std::size_t last = 0;
  trainer.progress = [&](std::size_t done, std::size_t total) {
    EXPECT_GE(done, last);
    EXPECT_EQ(total, 1000u);
    last = done;
  };
  EXPECT_EQ(trainer.step().phases.size(), 1u);
  EXPECT_EQ(last, 1000u);
}

/// The degree 3 is learnt for long before it is reduced, so that there is something to lose.
TrainOptions curriculum(ShTarget target, ShReduction reduce) {
  TrainOptions options = short_run(420);
  options.get<DensificationOptions>().until = 200;
  options.get<OpacityResetOptions>().interval = 0;
  options.get<ShCurriculumOptions>().interval = 20;
  options.sh_rest_lr = 2e-3;
  options.get<ShReductionOptions>().iteration = 400;
  options.get<ShReductionOptions>().target = target;
  options.get<ShReductionOptions>().reduce = reduce;
  return options;
}

TEST(ShReduction, ViewFitLosesLessThanTruncation) {
  const Told fitted = run(curriculum(ShTarget::degree_1, ShReduction::view_ls));
  const Told cut = run(curriculum(ShTarget::degree_1, ShReduction::truncate));
  ASSERT_TRUE(fitted.reduced && cut.reduced);
  EXPECT_EQ(fitted.reduced->iteration, 400);
  EXPECT_EQ(sh_degree_of(fitted.state.parameters), 1);
  EXPECT_EQ(sh_degree_of(fitted.state.adam.first), 1);
  const auto loss = [](const PhaseReport& r) { return r.train_psnr.before - r.train_psnr.after; };
  RecordProperty("fitted", std::to_string(loss(*fitted.reduced)));
  RecordProperty("truncated", std::to_string(loss(*cut.reduced)));
  EXPECT_EQ(fitted.reduced->train_psnr.before, cut.reduced->train_psnr.before);
  EXPECT_GT(loss(*cut.reduced), 0.2);  // or this scene says nothing
  EXPECT_LT(loss(*fitted.reduced), 0.5 * loss(*cut.reduced));
}

TEST(ShReduction, AdaptiveDegreesKeepTheirPromise) {
  TrainOptions options = curriculum(ShTarget::adaptive, ShReduction::view_ls);
  options.get<ShReductionOptions>().max_psnr_drop = 0.2;
  const Told told = run(options);
  ASSERT_TRUE(told.reduced);
  EXPECT_LT(told.reduced->train_psnr.before - told.reduced->train_psnr.after,
            options.get<ShReductionOptions>().max_psnr_drop);
  const auto degrees =
      told.reduced->details.at("splats_of_degree").get<std::array<std::size_t, 4>>();
  EXPECT_GT(degrees[0] + degrees[1], 0u);
  // What a splat lost stays lost while it is trained on
  for (std::size_t i = 0; i < told.state.degrees.size(); ++i)
    for (int r = row::count(told.state.degrees[i]); r < told.state.parameters.rows(); ++r)
      ASSERT_EQ(told.state.parameters.row(r)[i], 0) << i << ", row " << r;
}

// The error in the full images is mostly of details that are not trained yet: a share of that would
// be more than all SH coefficients are worth.
TEST(ShReduction, HalvedViewsSayHowMuchMayBeMissedOfThem) {
  TrainOptions options = curriculum(ShTarget::adaptive, ShReduction::view_ls);
  options.get<ProgressiveResolutionOptions>().levels = 1;
  options.get<ProgressiveResolutionOptions>().until = options.iterations;
  const Told told = run(options);
  ASSERT_TRUE(told.reduced);
  const auto degrees =
      told.reduced->details.at("splats_of_degree").get<std::array<std::size_t, 4>>();
  EXPECT_GT(4 * degrees[3], degrees[0]);  // 726 and 974; by the full images 24 and 2,195
}

TEST(ShReduction, EveryReductionTrainsOn) {
  for (const ShReduction reduce : {ShReduction::none, ShReduction::uniform_ls, ShReduction::energy})
    for (const bool psi : {false, true}) {
      TrainOptions options = curriculum(ShTarget::degree_1, reduce);
      options.iterations = 120;
      options.get<ShReductionOptions>().iteration = 100;
      options.get<NetworkColorOptions>().psi = psi;
      options.get<NetworkColorOptions>().psi_fit_iterations = 50;
      const Told told = run(options);
      EXPECT_EQ(told.reduced.has_value(), reduce != ShReduction::none);
      EXPECT_EQ(told.cloud.sh_degree, 1);
      EXPECT_EQ(told.state.attached.contains(kLatents), reduce == ShReduction::energy && psi);
      ASSERT_TRUE(told.stored);
      EXPECT_EQ(told.stored->cloud.size(), told.cloud.size());
    }
}

// Of c·d along an axis, the positive half is c/4 on the mean, and projects onto the axis' own
// harmonic as half of the whole does.
TEST(ShReduction, TheProjectedEnergyIsThatOfThePositivePart) {
  const Dataset& data = small_capture();
  const Threads threads(2);
  TrainOptions options = curriculum(ShTarget::degree_1, ShReduction::energy);
  options.get<ShReductionOptions>().samples = 4096;
  TrainState state = fresh(data, options);
  for (int r = row::sh_dc; r < state.parameters.rows(); ++r)
    std::fill_n(state.parameters.row(r), state.parameters.size(), 0.0f);
  for (int axis = 0; axis < 3; ++axis)
    state.parameters.row(row::sh_rest + 3 * axis)[axis] = 1;  // red, in the order of the basis
  const ViewWeights views = view_weights(state.parameters, cameras_of(data.train), {}, threads);
  const PlanarFloats energy =
      energy_moments(state.parameters, Residual::from_0, sphere_rule_of(options), threads);
  reduce_sh(state, options, views, 1e-3, threads);
  add_projection(energy, state.parameters);
  ASSERT_EQ(sh_degree_of(state.parameters), 1);
  for (int splat = 0; splat < 3; ++splat) {
    EXPECT_NEAR(state.parameters.row(row::sh_dc)[splat], std::numbers::pi * 0.2820948 * 0.4886025,
                2e-3);
    EXPECT_EQ(state.parameters.row(row::sh_dc + 1)[splat], 0);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(state.parameters.row(row::sh_rest + 3 * k)[splat], k == splat ? 1.5 : 0, 2e-3)
          << splat << ", " << k;
  }
}

TEST(NetworkColors, AreStoredOnlyWhereTheyPay) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  TrainOptions options = curriculum(ShTarget::degree_1, ShReduction::energy);
  options.iterations = 120;
  options.get<ShReductionOptions>().iteration = 100;
  options.get<NetworkColorOptions>().phi = true;
  const Told told = run(options);
  ASSERT_TRUE(told.stored && told.stored->with_networks && told.stored->without_networks);
  EXPECT_EQ(told.stored->file.size(),
            std::min(*told.stored->with_networks, *told.stored->without_networks));
  EXPECT_GT(*told.stored->with_networks, 40'000u);  // two networks are in it
}

// What is stored with networks is near the images that they make, not those without them
TEST(NetworkColors, AreJudgedByTheColoursThatTheyMake) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  TrainOptions options = curriculum(ShTarget::degree_1, ShReduction::view_ls);
  options.iterations = 110;
  options.get<ShReductionOptions>().iteration = 100;
  options.get<NetworkColorOptions>().phi = true;
  TrainState state = run(options).state;
  std::vector<double>& values = state.phase_values.at("network colours");
  auto model = model_from_floats(false, true, std::vector<float>(values.begin(), values.end()));
  ASSERT_TRUE(model);
  PlanarFloats& last = model->phi->weights.back();
  for (int r = 0; r < last.rows(); ++r)
    for (std::size_t i = 0; i < last.size(); ++i)
      last.row(r)[i] = 0.1f * std::sin(static_cast<float>(r + 3) * static_cast<float>(i + 1));
  const std::vector<float> floats = to_floats(*model);
  values.assign(floats.begin(), floats.end());
  const Dataset& data = small_capture();
  const Threads threads(2);
  Profiler times;
  const Trainer trainer(data, options, std::move(state), threads, times);
  const SplatCloud without = to_cloud(trainer.state.parameters, 1), with = trainer.cloud();
  const SceneError error(with, cameras_of(data.train), options.render, threads);
  EXPECT_LT(psnr_of_mse(*error.mse(without)), 30);  // or the networks change nothing
  const auto stored = store_scene(trainer, data.train, threads, {});
  ASSERT_TRUE(stored) << stored.error().message();
  ASSERT_FALSE(stored->networks_error) << stored->networks_error->message();
  EXPECT_GT(psnr_of_mse(*error.mse(stored->cloud)), trainer.compressed_psnr() - 0.5);
}

}  // namespace
}  // namespace fluxgs
