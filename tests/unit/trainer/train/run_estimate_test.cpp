// The time that a run still takes, and the splats that it comes to.
#include <gtest/gtest.h>

#include <cmath>

#include "trainer/compress/sh_reduction.h"
#include "trainer/train/progressive_resolution.h"
#include "trainer/train/run_estimate.h"
#include "trainer/train/sh_curriculum.h"
#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

/// A run in which nothing but the iterations takes place.
TrainOptions quiet_run(int iterations) {
  TrainOptions options = short_run(iterations);
  options.get<DensificationOptions>().from = 10 * iterations;
  options.get<OpacityResetOptions>().interval = 0;
  return options;
}

struct Running {
  explicit Running(const TrainOptions& options)
      : trainer(small_capture(), options, fresh(small_capture(), options), threads, times) {}

  Threads threads{2};
  Profiler times;
  Trainer trainer;
};

/// Seconds of an iteration, as the estimate is told: far more than one takes anywhere, since the
/// times of its stages are real ones.
constexpr double kEach = 100;

TEST(RunEstimate, IterationsLikeThoseBeforeTakeAsLong) {
  Running run(quiet_run(200));
  RunEstimate estimate(run.trainer, {});
  EXPECT_EQ(estimate.seconds_left(), 0);
  while (!run.trainer.done()) {
    run.trainer.step();
    estimate.add(kEach);
    const int left = 200 - run.trainer.state.iteration;
    EXPECT_NEAR(estimate.seconds_left(), kEach * left, 0.05 * kEach * left + 1e-9) << left;
  }
}

TEST(RunEstimate, AnIterationThatWasStoppedDoesNotCount) {
  Running run(quiet_run(60));
  RunEstimate estimate(run.trainer, {});
  while (!run.trainer.done()) {
    run.trainer.step();
    estimate.add(run.trainer.state.iteration == 30 ? 2000 * kEach : kEach);
    const int left = 60 - run.trainer.state.iteration;
    EXPECT_NEAR(estimate.seconds_left(), kEach * left, 0.05 * kEach * left + 1e-9) << left;
  }
}

TEST(RunEstimate, SmallerImagesAreCountedAsSuch) {
  TrainOptions options = quiet_run(40);
  options.get<ProgressiveResolutionOptions>().levels = 1;
  options.get<ProgressiveResolutionOptions>().until = 20;
  Running run(options);
  const Camera& whole = small_capture().train[0].camera;
  while (!run.trainer.done()) {
    run.trainer.step();
    double share = 1;
    for (const auto& phase : run.trainer.schedule().phases)
      share *= phase->pixel_share(run.trainer.state.iteration);
    const Camera& camera = run.trainer.view->camera;
    EXPECT_NEAR(share,
                static_cast<double>(camera.width * camera.height) / (whole.width * whole.height),
                0.02)
        << run.trainer.state.iteration;
  }
}

TEST(RunEstimate, DegreesOfSphericalHarmonicsAreThoseOfTheRun) {
  for (const ShTarget target : {ShTarget::degree_1, ShTarget::adaptive}) {
    TrainOptions options = quiet_run(40);
    options.sh_degree = 3;
    options.get<ShCurriculumOptions>().interval = 5;
    options.get<ShReductionOptions>().target = target;
    options.get<ShReductionOptions>().iteration = 25;
    Running run(options);
    while (!run.trainer.done()) {
      run.trainer.step();
      int degree = 3;
      for (const auto& phase : run.trainer.schedule().phases)
        degree = phase->sh_degree(run.trainer.state.iteration, degree);
      EXPECT_EQ(degree, run.trainer.render.sh_degree) << run.trainer.state.iteration;
    }
  }
}

TEST(RunEstimate, PausesAndStoringComeOnTop) {
  TrainOptions options = quiet_run(100);
  Running run(options);
  const LaterWork storing{.storing = {.renders = 1000}};
  RunEstimate with(run.trainer, storing), without(run.trainer, {});
  for (int i = 0; i < 20; ++i) {
    run.trainer.step();
    with.add(kEach);
    without.add(kEach);
  }
  EXPECT_GT(with.seconds_left(), without.seconds_left());

  options.get<LatePruningOptions>().mode = LatePrune::contribution;
  options.get<LatePruningOptions>().from = 50;
  options.get<LatePruningOptions>().until = 50;
  Running pruned(options);
  RunEstimate pausing(pruned.trainer, {});
  for (int i = 0; i < 60; ++i) {
    pruned.trainer.step();
    pausing.add(i == 49 ? 500 * kEach : kEach);
    // The pause is over: it is not taken for the rate of what is left
    if (i == 55) {
      EXPECT_GT(pausing.seconds_left(), 0);
      EXPECT_LT(pausing.seconds_left(), 1.2 * 44 * kEach);
    }
  }
}

TEST(RunEstimate, GrowthIsThatOfTheStrategyThenThatOfTheRun) {
  TrainOptions options = short_run(100);
  auto& densification = options.get<DensificationOptions>();
  densification.from = 20, densification.until = 60, densification.interval = 20;
  densification.growth = 0.01;
  Running run(options);
  const auto first = static_cast<double>(run.trainer.state.parameters.size());
  RunEstimate estimate(run.trainer, {});
  EXPECT_NEAR(std::log(estimate.peak_splats() / first), 3 * 0.9 * std::log(1.01), 1e-9);
  double most = first;
  while (!run.trainer.done()) {
    run.trainer.step();
    estimate.add(0.01);
    most = std::max(most, static_cast<double>(run.trainer.state.parameters.size()));
  }
  EXPECT_LE(estimate.peak_splats(), most);
  options.max_splats = static_cast<std::uint64_t>(first);
  Running limited(options);
  EXPECT_LE(RunEstimate(limited.trainer, {}).peak_splats(), first);
}

TEST(RunEstimate, MemoryGrowsWithTheSplatsToCome) {
  TrainOptions options = short_run(100);
  options.get<DensificationOptions>().growth = 0.15;
  Running growing(options), quiet(quiet_run(100));
  EXPECT_GT(RunEstimate(growing.trainer, {}).peak_memory(),
            RunEstimate(quiet.trainer, {}).peak_memory());
}

}  // namespace
}  // namespace fluxgs
