// Cameras around a scene: a full circle, or the arc that the images cover.
#include "tools/fluxgs/cameras/orbit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "support/scenes.h"

namespace fluxgs::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr ImageSize kSize{64, 48};

/// Images from 3 units around a point that is far from the origin, one unit above it (y is down).
const glm::dvec3 kCenter(100, -20, 7);

std::vector<View> views_at(const std::vector<double>& degrees) {
  std::vector<View> views;
  for (double d : degrees) {
    const glm::dvec3 arm(3 * std::sin(d * kDegree), -1, -3 * std::cos(d * kDegree));
    views.emplace_back().camera = test::camera_at(kCenter + arm, kCenter, 64, 48);
  }
  return views;
}

double azimuth(const Camera& camera) {
  const glm::dvec3 arm = camera.center() - kCenter;
  return std::atan2(arm.x, -arm.z) / kDegree;
}

void expect_seen_in_the_middle(const Camera& camera, const glm::dvec3& point) {
  const glm::dvec3 p = camera.rotation * point + camera.translation;
  EXPECT_GT(p.z, 0);
  EXPECT_NEAR(camera.fx * p.x / p.z, 0, 0.5);
  EXPECT_NEAR(camera.fy * p.y / p.z, 0, 0.5);
}

TEST(Orbit, GoesAllAroundWhereViewsDo) {
  const auto cameras = orbit_along(views_at({0, 45, 90, 135, 180, 225, 270, 315}), 4, kSize);
  ASSERT_EQ(cameras.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(glm::distance(cameras[i].center(), kCenter), std::sqrt(10.0), 0.01);
    EXPECT_NEAR(cameras[i].center().y, kCenter.y - 1, 0.031);
    expect_seen_in_the_middle(cameras[i], kCenter);
    EXPECT_NEAR(glm::distance(cameras[i].center(), cameras[(i + 1) % 4].center()),
                3 * std::sqrt(2.0), 0.01);
  }
}

TEST(Orbit, StaysOnTheArcThatTheViewsCover) {
  for (const double middle : {0.0, 100.0, 180.0, -90.0}) {
    const auto views = views_at({middle + 20, middle - 60, middle, middle + 60, middle - 30});
    auto cameras = orbit_along(views, 5, kSize);
    ASSERT_EQ(cameras.size(), 5u);
    std::vector<double> turns;
    for (const Camera& camera : cameras) {
      turns.push_back(std::remainder(azimuth(camera) - middle, 360.0));
      expect_seen_in_the_middle(camera, kCenter);
    }
    if (turns.front() > 0) std::ranges::reverse(turns);
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_NEAR(turns[i], -54 + 27 * static_cast<double>(i), 1.5) << middle;
    cameras = orbit_along(views, 1, kSize);
    EXPECT_NEAR(std::remainder(azimuth(cameras[0]) - middle, 360.0), 0, 1.5);
  }
}

TEST(Orbit, ViewsFromOnePlaceGiveFiniteCameras) {
  std::vector<View> views = views_at({10});
  for (int count : {1, 3})
    for (const Camera& camera : orbit_along(views, count, kSize))
      EXPECT_TRUE(std::isfinite(glm::dot(camera.center(), camera.forward())));
  // A panorama: the views leave one place in opposite directions, and so have no common centre
  views = views_at({0, 180});
  views[0].camera.translation = views[0].camera.rotation * -kCenter;
  views[1].camera.translation = views[1].camera.rotation * -kCenter;
  for (const Camera& camera : orbit_along(views, 3, kSize))
    EXPECT_TRUE(std::isfinite(glm::dot(camera.center(), camera.forward())));
}

TEST(Orbit, AroundSplatsLeavesFarFloatersOut) {
  SplatCloud cloud = test::random_cloud(1000, 0, 3);
  for (glm::vec3& p : cloud.positions) p += glm::vec3(kCenter);
  cloud.positions[0] = glm::vec3(1e6f, 0, 0);
  for (const Camera& camera : orbit_around(cloud, 6, kSize)) {
    EXPECT_LT(glm::distance(camera.center(), kCenter), 10);
    EXPECT_LT(camera.center().y, kCenter.y);  // above, as y is down
    expect_seen_in_the_middle(camera, camera.center() + 5.0 * camera.forward());
  }
  EXPECT_EQ(orbit_around(SplatCloud(), 2, kSize).size(), 2u);
}

TEST(Orbit, FewSplatsAreSeenInFewPixels) {
  const std::pair<std::size_t, int> widths[] = {
      {0, 160}, {1000, 160}, {7500, 320}, {30000, 640}, {4000000, 640}};
  for (const auto& [splats, width] : widths) {
    EXPECT_EQ(reduction_size(splats).width, width) << splats;
    EXPECT_EQ(reduction_size(splats).height, width * 3 / 4) << splats;
  }
}

}  // namespace
}  // namespace fluxgs::cli
