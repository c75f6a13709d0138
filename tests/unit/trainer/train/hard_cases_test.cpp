// Data that nobody should train on: a run goes on, or stops with a clear line.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/core/psnr.h"
#include "trainer/train/evaluate.h"
#include "trainer/train/store_scene.h"
#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

void expect_finite(const PlanarFloats& rows) {
  for (int r = 0; r < rows.rows(); ++r)
    for (std::size_t i = 0; i < rows.size(); ++i)
      ASSERT_TRUE(std::isfinite(rows.row(r)[i])) << "row " << r << ", splat " << i;
}

/// Trains and stores; what comes out is finite.
void expect_survives(const Dataset& data, const TrainOptions& options, const PointCloud& points) {
  const Threads threads(2);
  Profiler times;
  Trainer trainer(data, options, initial_state(data, points, options, threads), threads, times);
  while (!trainer.done()) {
    const IterationReport step = trainer.step();
    ASSERT_TRUE(std::isfinite(step.loss)) << trainer.state.iteration;
  }
  expect_finite(trainer.state.parameters);
  const auto stored = store_scene(trainer, data.train, threads, {});
  ASSERT_TRUE(stored) << stored.error().message();
  EXPECT_EQ(stored->cloud.size(), trainer.state.parameters.size());
}

/// Networks make the colours of the last steps.
TrainOptions networks_run() {
  TrainOptions options = short_run(50);
  options.get<ShCurriculumOptions>().interval = 10;
  options.get<ShReductionOptions>().iteration = 40;
  options.get<ShReductionOptions>().target = ShTarget::degree_1;
  options.get<ShReductionOptions>().reduce = ShReduction::energy;
  options.get<NetworkColorOptions>().psi = options.get<NetworkColorOptions>().phi = true;
  options.get<NetworkColorOptions>().psi_fit_iterations = 10;
  return options;
}

/// Each kind of run on its own, so that they share the cores.
struct Run {
  const char* name;
  TrainOptions (*options)();
};

class HardViews : public testing::TestWithParam<Run> {
 protected:
  void expect_survives(const Dataset& data) const {
    fluxgs::expect_survives(data, GetParam().options(), points_of(small_capture()));
  }
};

INSTANTIATE_TEST_SUITE_P(Runs, HardViews,
                         testing::Values(Run{"everything", everything},
                                         Run{"plain", [] { return short_run(60); }},
                                         Run{"networks", networks_run},
                                         Run{"mcmc", [] { return mcmc_run(50); }}),
                         [](const auto& run) { return std::string(run.param.name); });

/// The capture with its images changed.
template <class Change>
Dataset changed(const Change& change) {
  Dataset data = small_capture();
  change(data);
  return data;
}

void paint(Dataset& data, std::uint8_t value) {
  for (View& view : data.train) std::ranges::fill(view.rgb.pixels, value);
}

TEST_P(HardViews, BlackViews) {
  expect_survives(changed([](Dataset& d) { paint(d, 0); }));
}

TEST_P(HardViews, WhiteViews) {
  expect_survives(changed([](Dataset& d) { paint(d, 255); }));
}

// A lens cap, or a mask with nothing in it: an image that is its image is infinitely many decibels
// from it, which must not be the mean of all.
Dataset with_an_empty_view() {
  return changed([](Dataset& d) {
    View& view = d.train[0];
    std::ranges::fill(view.rgb.pixels, std::uint8_t{0});
    for (const int axis : {0, 2}) {  // turned about, and out of the scene
      for (int c = 0; c < 3; ++c) view.camera.rotation[c][axis] *= -1;
      view.camera.translation[axis] *= -1;
    }
    view.camera.translation.z -= 30;
  });
}

TEST_P(HardViews, AViewThatIsReproducedExactly) { expect_survives(with_an_empty_view()); }

TEST(HardData, MeansOfAViewThatIsReproducedExactly) {
  const Dataset data = with_an_empty_view();
  const TrainOptions options = everything();
  const Threads threads(2);
  Profiler times;
  const Trainer start(data, options,
                      initial_state(data, points_of(small_capture()), options, threads), threads,
                      times);
  const auto scores =
      evaluate(data.train, cpu_view_renderer(start.cloud(), options.render, threads), threads);
  ASSERT_TRUE(scores);
  EXPECT_EQ(scores->views.front().psnr, kMaxPsnr);
  EXPECT_LT(scores->psnr, kMaxPsnr);
  EXPECT_LT(start.mean_psnr(data.train), 58.93);
}

TEST_P(HardViews, OneView) {
  expect_survives(changed([](Dataset& d) { d.train.resize(1); }));
}

TEST_P(HardViews, TwoCameras) {
  expect_survives(changed([](Dataset& d) { d.train.resize(2); }));
}

TEST_P(HardViews, TheSameCameraAgainAndAgain) {
  expect_survives(changed([](Dataset& d) {
    for (View& view : d.train) view.camera = d.train[0].camera;
  }));
}

TEST_P(HardViews, CamerasThatLookTheSameWay) {
  expect_survives(changed([](Dataset& d) {
    for (std::size_t i = 0; i < d.train.size(); ++i) {
      d.train[i].camera.rotation = d.train[0].camera.rotation;
      d.train[i].camera.translation = d.train[0].camera.translation;
      d.train[i].camera.translation.x += 0.1 * static_cast<double>(i);
    }
  }));
}

TEST(HardData, CamerasInsideWalls) {
  const Dataset& data = small_capture();
  PointCloud points = points_of(data);
  // A point at each camera's centre, and before its lens
  for (std::size_t i = 0; i < data.train.size(); ++i) {
    const Camera& camera = data.train[i].camera;
    points.positions[2 * i] = camera.center();
    points.positions[2 * i + 1] =
        camera.center() +
        0.02 * glm::dvec3(camera.rotation[0][2], camera.rotation[1][2], camera.rotation[2][2]);
  }
  for (const auto& options : {everything(), short_run(60)}) expect_survives(data, options, points);
}

TEST(HardData, OneAndTwoPoints) {
  PointCloud points = points_of(small_capture());
  for (std::size_t count : {1, 2}) {
    points.positions.resize(count);
    points.colors.resize(count);
    expect_survives(small_capture(), everything(), points);
  }
}

TEST(HardData, AllPointsInOnePlace) {
  PointCloud points = points_of(small_capture());
  for (auto& position : points.positions) position = points.positions[0];
  expect_survives(small_capture(), everything(), points);
}

TEST(HardData, AWorldFarFromItsOrigin) {
  const glm::dvec3 far(1e5, -1e5, 1e5);
  PointCloud points = points_of(small_capture());
  for (auto& position : points.positions) position += far;
  expect_survives(changed([&](Dataset& d) {
                    for (View& view : d.train)
                      view.camera.translation -= view.camera.rotation * far;
                  }),
                  everything(), points);
}

TEST(HardData, NeedlesAndGiants) {
  const Dataset& data = small_capture();
  const TrainOptions options = everything();
  const Threads threads(2);
  TrainState state = fresh(data, options);
  for (std::size_t i = 0; i < state.parameters.size(); i += 3) {
    state.parameters.row(row::log_scale)[i] = i % 2 == 0 ? 3.0f : -20.0f;
    state.parameters.row(row::log_scale + 1)[i] = -20.0f;
  }
  Profiler times;
  Trainer trainer(data, options, std::move(state), threads, times);
  while (!trainer.done()) ASSERT_TRUE(std::isfinite(trainer.step().loss));
  expect_finite(trainer.state.parameters);
}

}  // namespace
}  // namespace fluxgs
