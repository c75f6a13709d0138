// Anti-aliased trainings: the filter of the scene, and the smallest splats.
#include "trainer/train/antialiasing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "trainer/train/store_scene.h"
#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

/// A camera at the origin that looks along z, 100 px of focal length, 80×60.
Camera straight(double z, double focal) {
  Camera camera;
  camera.width = 80, camera.height = 60;
  camera.fx = camera.fy = focal;
  camera.cx = 40, camera.cy = 30;
  camera.rotation = glm::dmat3(1);
  camera.translation = {0, 0, z};
  return camera;
}

PlanarFloats at(std::initializer_list<glm::vec3> positions) {
  SplatCloud cloud;
  cloud.resize(positions.size());
  std::ranges::copy(positions, cloud.positions.begin());
  return to_parameters(cloud, 0);
}

TEST(Antialiasing, TheSmallestDeviationIsThatOfTheNearestView) {
  const Threads threads(2);
  const PlanarFloats parameters = at({{0, 0, 5}, {0, 0, -5}, {1000, 0, 5}, {0, 0, 50}});
  const std::vector<Camera> cameras = {straight(0, 100), straight(5, 100), straight(5, 150)};
  const auto least = min_deviations(parameters, cameras, 0.2, threads);
  EXPECT_NEAR(least[0], std::sqrt(0.2) * 5 / 100, 1e-6);   // nearest in the first
  EXPECT_EQ(least[1], 0);                                  // behind all of them
  EXPECT_EQ(least[2], 0);                                  // beside their images
  EXPECT_NEAR(least[3], std::sqrt(0.2) * 55 / 150, 1e-6);  // largest in the last, though farther
}

TrainOptions antialiased(bool on) {
  TrainOptions options = short_run(200);
  options.get<AntialiasingOptions>().antialias = on;
  options.get<AntialiasingOptions>().dilation = 0.25;
  return options;
}

/// A run that begins with needles.
SplatCloud trained(const TrainOptions& options) {
  const Dataset& data = small_capture();
  const Threads threads(2);
  Profiler times;
  TrainState state = fresh(data, options);
  for (std::size_t i = 0; i < state.parameters.size(); ++i)
    state.parameters.row(row::log_scale + 1)[i] -= 5;
  Trainer trainer(data, options, std::move(state), threads, times);
  while (!trainer.done()) trainer.step();
  return trainer.cloud();
}

/// Share of splats with an axis of less than 0.99 of the smallest deviation.
double finer_than_shown(const SplatCloud& cloud) {
  const Threads threads(2);
  std::vector<Camera> cameras;
  for (const View& view : small_capture().train) cameras.push_back(view.camera);
  const auto least = min_deviations(to_parameters(cloud, 0), cameras, 0.2, threads);
  std::size_t finer = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 s = glm::exp(cloud.log_scales[i]);
    finer += std::min({s.x, s.y, s.z}) < 0.99f * least[i];
  }
  return static_cast<double>(finer) / static_cast<double>(cloud.size());
}

TEST(Antialiasing, NoSplatIsFinerThanTheImagesShow) {
  const SplatCloud filtered = trained(antialiased(true)), classic = trained(antialiased(false));
  EXPECT_EQ(filtered.filter, (ScreenFilter{0.25, true}));
  EXPECT_EQ(classic.filter, ScreenFilter{});
  EXPECT_EQ(finer_than_shown(filtered), 0);
  EXPECT_GT(finer_than_shown(classic), 0.02);  // or this scene says nothing
}

}  // namespace
}  // namespace fluxgs
