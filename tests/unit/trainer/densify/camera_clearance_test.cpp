// No splat has a camera inside.
#include "trainer/densify/camera_clearance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace fluxgs {
namespace {

/// A splat at the origin with standard deviations 1, 2 and 4 along x, y and z, all turned by 90°
/// about z: y, x and z in the world. Its quaternion is not of unit length.
PlanarFloats turned_splat() {
  PlanarFloats parameters(row::count(0), 1);
  for (int c = 0; c < 3; ++c)
    parameters.row(row::log_scale + c)[0] = static_cast<float>(c * std::log(2.0));
  parameters.row(row::rotation)[0] = 3;
  parameters.row(row::rotation + 3)[0] = 3;
  return parameters;
}

double size_after(const std::vector<glm::dvec3>& cameras, double clearance) {
  PlanarFloats parameters = turned_splat();
  clear_cameras(cameras, clearance, parameters, Threads(1));
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(parameters.row(row::log_scale + c)[0] - parameters.row(row::log_scale)[0],
                c * std::log(2.0), 1e-6);  // its shape stays
  return std::exp(parameters.row(row::log_scale)[0]);
}

TEST(CameraClearance, DistancesAreMeasuredInTheSplatsOwnAxes) {
  // Along the world's x the deviation is 2, along y 1, along z 4
  EXPECT_NEAR(size_after({{3, 0, 0}}, 2), 0.75, 1e-6);
  EXPECT_NEAR(size_after({{0, 1.5, 0}}, 2), 0.75, 1e-6);
  EXPECT_NEAR(size_after({{0, 0, 6}}, 2), 0.75, 1e-6);
  EXPECT_EQ(size_after({{4.1, 0, 0}}, 2), 1);
  EXPECT_EQ(size_after({{0, 2.1, 0}}, 2), 1);
}

TEST(CameraClearance, TheNearestCameraCounts) {
  EXPECT_NEAR(size_after({{50, 0, 0}, {3, 0, 0}, {2, 0, 0}, {0, 0, 7}}, 2), 0.5, 1e-6);
}

TEST(CameraClearance, ACameraInTheMiddleLeavesAQuarter) {
  EXPECT_NEAR(size_after({{0, 0, 0}}, 2), 0.25, 1e-6);
}

TEST(CameraClearance, NothingChangesWithoutCamerasOrClearance) {
  EXPECT_EQ(size_after({}, 2), 1);
  EXPECT_EQ(size_after({{0, 0, 0}}, 0), 1);
}

TEST(CameraClearance, OnlySplatsNearCamerasChange) {
  PlanarFloats parameters(row::count(0), 3000);
  for (std::size_t i = 0; i < 3000; ++i) {
    parameters.row(row::rotation)[i] = 1;
    parameters.row(row::position)[i] = static_cast<float>(i);
  }
  clear_cameras({{5, 0, 0}, {2000, 0, 0}}, 1.5, parameters, Threads(2));
  const float* sizes = parameters.row(row::log_scale);
  EXPECT_EQ(std::count_if(sizes, sizes + 3000, [](float size) { return size != 0; }), 6);
  EXPECT_EQ(parameters.row(row::log_scale)[4], static_cast<float>(std::log(1 / 1.5)));
  EXPECT_EQ(parameters.row(row::log_scale)[7], 0);
}

TEST(CameraClearance, IsAPhaseOnlyWithAClearance) {
  TrainOptions options;
  EXPECT_EQ(make_camera_clearance(options), nullptr);
  options.get<CameraClearanceOptions>().clearance = 2;
  const auto phase = make_camera_clearance(options);
  ASSERT_NE(phase, nullptr);
  EXPECT_LT(phase->period().until, options.iterations);
}

}  // namespace
}  // namespace fluxgs
