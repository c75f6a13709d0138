// Which views scores are taken from.
#include "trainer/densify/camera_sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support/scenes.h"

namespace fluxgs {
namespace {

std::vector<View> views_at(const std::vector<glm::dvec3>& eyes) {
  std::vector<View> views;
  for (const glm::dvec3& eye : eyes)
    views.push_back({test::camera_at(eye, {0, 0, 0}, 8, 8), {}, {}});
  return views;
}

/// 30 cameras in one place and one at each of five others.
std::vector<glm::dvec3> lopsided() {
  std::vector<glm::dvec3> eyes(30, {3, 0.1, 0.2});
  for (int k = 1; k < 6; ++k) eyes.push_back({3 * std::cos(k + 0.1), 3 * std::sin(k + 0.1), 0.2});
  return eyes;
}

TEST(CameraSampling, BinsFollowAzimuthAndElevation) {
  const auto bins = camera_bins(
      views_at({{3, 0.1, 0.2}, {3, 0.2, 0.2}, {-3, 0.1, 0.2}, {3, 0.1, 4.0}, {3, 0.1, -4.0}}), 12,
      6);
  ASSERT_EQ(bins.size(), 4u);
  std::set<std::vector<std::uint32_t>> found(bins.begin(), bins.end());
  EXPECT_TRUE(found.contains({0, 1}));
  EXPECT_TRUE(found.contains({2}));
}

TEST(CameraSampling, StratifiedTakesOneOfEachBinFirst) {
  const std::vector<View> views = views_at(lopsided());
  ScoreOptions options;  // 6 of 12 x 6 bins
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto chosen = sample_cameras(views, options, random);
    std::set<std::uint32_t> places;
    for (std::uint32_t i : chosen) places.insert(std::max(i, 29u));
    EXPECT_EQ(places.size(), 6u);
  }
  options.sampling = CameraSampling::random;
  double crowded = 0;
  for (int trial = 0; trial < 50; ++trial)
    for (std::uint32_t i : sample_cameras(views, options, random)) crowded += i < 30;
  EXPECT_GT(crowded / 50, 4);  // 6 · 30/35 = 5.1 are expected
}

TEST(CameraSampling, NeverTwiceTheSameAndNeverMoreThanThereAre) {
  const std::vector<View> views = views_at(lopsided());
  ScoreOptions options;
  for (const CameraSampling way : {CameraSampling::stratified, CameraSampling::random}) {
    options.sampling = way;
    for (const int count : {1, 12, 35, 100}) {
      options.views = count;
      Random random(7);
      const auto chosen = sample_cameras(views, options, random);
      EXPECT_EQ(chosen.size(), static_cast<std::size_t>(std::min(count, 35)));
      EXPECT_EQ(std::set<std::uint32_t>(chosen.begin(), chosen.end()).size(), chosen.size());
    }
  }
}

TEST(CameraSampling, ParallelViewsAndEqualCamerasAreFine) {
  std::vector<View> parallel;
  for (int i = 0; i < 4; ++i) {
    View view{test::camera_in_front(8, 8), {}, {}};
    view.camera.translation.x = i;
    parallel.push_back(view);
  }
  Random random(1);
  EXPECT_EQ(sample_cameras(parallel, {}, random).size(), 4u);
  const std::vector<View> equal(3, parallel[0]);
  EXPECT_EQ(camera_bins(equal, 12, 6).size(), 1u);
  EXPECT_EQ(sample_cameras(equal, {}, random).size(), 3u);
}

}  // namespace
}  // namespace fluxgs
