// The training loop: it learns, and gives the same bytes whatever the threads.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "support/sanitized.h"
#include "trainer/train/evaluate.h"
#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

TEST(Train, LearnsTheScene) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(800);
  options.get<DensificationOptions>().until = 600;
  options.get<OpacityResetOptions>().interval = 0;
  const Threads threads(2);
  const auto score = [&](const TrainState& state, const std::vector<View>& views) {
    const SplatCloud cloud = to_cloud(state.parameters, 3);
    return evaluate(views, cpu_view_renderer(cloud, options.render, threads), threads)->psnr;
  };
  const TrainState start = fresh(data, options);
  const TrainState end = train(data, options, start, 2, 800);
  RecordProperty("train_psnr", std::to_string(score(end, data.train)));
  RecordProperty("test_psnr", std::to_string(score(end, data.test)));
  EXPECT_GT(score(end, data.train), 19.0);
  EXPECT_GT(score(end, data.test), score(start, data.test) + 5.0);  // views it has never seen
}

TEST(Train, SameBytesForAnyNumberOfThreads) {
  const Dataset& data = small_capture();
  for (const TrainOptions& options : {short_run(100), everything(), mcmc_run(100)}) {
    const TrainState one = train(data, options, fresh(data, options), 1, 100);
    for (int threads : kSanitized ? std::vector{2} : std::vector{2, 4})
      expect_same(one, train(data, options, fresh(data, options), threads, 100));
  }
}

TEST(Train, CamerasInOnePlaceHaveAnExtent) {
  std::vector<View> views = small_capture().train;
  const double extent = scene_extent(views);
  EXPECT_GT(extent, 0.1);
  for (View& view : views) view.camera = views[1].camera;
  EXPECT_EQ(scene_extent(views), 1.0);
  views.resize(1);
  EXPECT_EQ(scene_extent(views), 1.0);
}

TEST(Cooldown, RatesFallLogLinearlyAtTheEnd) {
  CommonOptions o;
  o.iterations = 1000;
  EXPECT_EQ(cooldown_factor(o, 1000), 1);  // off
  o.cooldown = 0.4;
  o.cooldown_to = 0.01;
  EXPECT_EQ(cooldown_factor(o, 1), 1);
  EXPECT_EQ(cooldown_factor(o, 600), 1);
  EXPECT_NEAR(cooldown_factor(o, 800), 0.1, 1e-12);
  EXPECT_NEAR(cooldown_factor(o, 1000), 0.01, 1e-12);
  EXPECT_NEAR(cooldown_factor(o, 1200), 0.01, 1e-12);  // resumed beyond its length
  o.cooldown = 1;
  EXPECT_NEAR(cooldown_factor(o, 500), 0.1, 1e-12);
}

TEST(Train, SeedsChangeTheResult) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(10);
  const TrainState one = train(data, options, fresh(data, options), 2, 10);
  options.seed = 2;
  const TrainState two = train(data, options, fresh(data, options), 2, 10);
  EXPECT_NE(one.view_order, two.view_order);
}

TEST(Train, NonFiniteGradientsAreSkippedAndCounted) {
  const Dataset& data = small_capture();
  const TrainOptions options = short_run(5);
  TrainState state = fresh(data, options);
  // A colour whose square is infinite: SSIM's gradient is not finite where it is seen
  for (int c = 0; c < 3; ++c) state.parameters.row(row::sh_dc + c)[0] = 1e38f;
  const Threads threads(2);
  Profiler times;
  Trainer trainer(data, options, std::move(state), threads, times);
  while (!trainer.done()) trainer.step();
  EXPECT_GT(trainer.rejected_gradients(), 0u);
  const TrainState& after = trainer.state;
  for (int r = 0; r < after.parameters.rows(); ++r)
    for (std::size_t i = 0; i < after.parameters.size(); ++i)
      ASSERT_TRUE(std::isfinite(after.parameters.row(r)[i]));
}

TEST(Profiler, NoSecondIsInTwoStages) {
  using namespace std::chrono_literals;
  Profiler times;
  const double start = wall_seconds(), cpu_start = cpu_seconds();
  {
    const ProfileScope outer(times, "densify");
    std::this_thread::sleep_for(20ms);
    {
      const ProfileScope inner(times, "forward");
      std::this_thread::sleep_for(50ms);
      const ProfileScope innermost(times, "sort");
      std::this_thread::sleep_for(10ms);
    }
    std::this_thread::sleep_for(20ms);
  }
  {
    const ProfileScope again(times, "forward");
    const double busy = cpu_seconds();
    while (cpu_seconds() - busy < 0.020) {
    }
  }
  const double all = wall_seconds() - start, cpu_all = cpu_seconds() - cpu_start;
  EXPECT_GE(times["densify"], 0.040);
  EXPECT_GE(times["forward"], 0.050);
  EXPECT_GE(times["sort"], 0.010);
  constexpr double rounding = 1e-6;  // of sums of differences, in seconds
  EXPECT_LE(times["densify"] + times["forward"] + times["sort"], all + rounding);
  ASSERT_EQ(times.cpu_entries().size(), 3U);
  double cpu = 0;
  for (const auto& [name, seconds] : times.cpu_entries()) {
    EXPECT_GE(seconds, name == "forward" ? 0.020 : 0) << name;
    cpu += seconds;
  }
  EXPECT_LE(cpu, cpu_all + rounding);
}

TEST(Train, LatePruningSeesOpacitiesBeforeTheyAreReset) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(80);
  options.get<DensificationOptions>().until = 60;
  options.get<OpacityResetOptions>().interval = 40;
  options.get<LatePruningOptions>().mode = LatePrune::contribution;
  options.get<LatePruningOptions>().from = options.get<LatePruningOptions>().interval = 40;
  const Threads threads(2);
  Profiler times;
  Trainer trainer(data, options, fresh(data, options), threads, times);
  IterationReport report;
  for (int i = 0; i < 40; ++i) report = trainer.step();
  ASSERT_EQ(report.phases.size(), 1u);
  const PhaseReport& pruned = report.phases[0];
  EXPECT_EQ(pruned.name, "late pruning");
  EXPECT_EQ(pruned.iteration, 40);
  const auto reset =
      evaluate(data.train, cpu_view_renderer(trainer.cloud(), options.render, threads), threads);
  ASSERT_TRUE(reset);
  EXPECT_LT(pruned.splats.after, pruned.splats.before);
  EXPECT_GT(pruned.train_psnr.after, reset->psnr + 2);
  ASSERT_TRUE(pruned.test_psnr);
  EXPECT_NEAR(pruned.test_psnr->after, pruned.train_psnr.after, 10);
}

TEST(Train, FoxForAShortWhile) {
  const char* folder = std::getenv("FLUXGS_DATA");
  if (!folder || !std::filesystem::is_directory(std::filesystem::path(folder) / "fox"))
    GTEST_SKIP() << "FLUXGS_DATA names no folder with fox";
  LoadOptions load;
  load.downscale = 8;
  const auto data = load_dataset(std::filesystem::path(folder) / "fox", load);
  ASSERT_TRUE(data) << data.error().message();
  TrainOptions options;
  options.iterations = 600;
  options.get<DensificationOptions>().from = 200;
  const Threads threads(2);
  const TrainState state = train(*data, options, fresh(*data, options), 2, 600);
  const auto score =
      evaluate(data->test,
               cpu_view_renderer(to_cloud(state.parameters, 3), options.render, threads), threads);
  ASSERT_TRUE(score);
  RecordProperty("psnr", std::to_string(score->psnr));
  EXPECT_GT(score->psnr, 19.0);
}

}  // namespace
}  // namespace fluxgs
