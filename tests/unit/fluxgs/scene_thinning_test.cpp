// The splats that are left where a scene may have fewer.
#include "tools/fluxgs/commands/scene_thinning.h"

#include <gtest/gtest.h>

#include <limits>

#include "unit/renderer/scenes.h"

namespace fluxgs::cli {
namespace {

/// A wall of nine splats, a large one behind its middle, and a small one beside it.
SplatCloud wall() {
  SplatCloud cloud;
  for (int i = 0; i < 9; ++i)
    for (int layer = 0; layer < 8; ++layer) {
      const auto x = static_cast<float>(i % 3 - 1), y = static_cast<float>(i / 3 - 1);
      test::add(cloud, {.position = {0.2F * x, 0.2F * y, 0.001F * static_cast<float>(layer)},
                        .scale = glm::vec3(0.2F),
                        .opacity = 0.9F});
    }
  test::add(cloud, {.position = {0, 0, 2}, .scale = glm::vec3(0.15F), .opacity = 0.99F});
  test::add(cloud, {.position = {1.2F, 0, 0}, .scale = glm::vec3(0.05F), .opacity = 0.9F});
  return cloud;
}

bool has(const SplatCloud& cloud, const glm::vec3& position) {
  return std::ranges::find(cloud.positions, position) != cloud.positions.end();
}

TEST(SceneThinning, WhatCamerasDoNotSeeGoesFirst) {
  const Threads threads(1);
  SplatCloud seen = wall(), unseen = wall();
  const std::size_t count = 27;
  keep_most_contributing(seen, count, {test::front_camera(160, 120, 2)}, {}, threads);
  keep_most_contributing(unseen, count, {}, {}, threads);
  EXPECT_EQ(seen.size(), count);
  EXPECT_EQ(unseen.size(), count);
  EXPECT_TRUE(has(seen, {1.2F, 0, 0})) << "small, but nothing hides it";
  EXPECT_FALSE(has(seen, {0, 0, 2})) << "large, but hidden";
  EXPECT_FALSE(has(unseen, {1.2F, 0, 0}));
}

TEST(SceneThinning, AsManyAsThereAreStayAsTheyAre) {
  const Threads threads(1);
  SplatCloud cloud = wall();
  const auto positions = cloud.positions;
  for (const std::size_t count :
       {cloud.size(), cloud.size() + 1, std::numeric_limits<std::size_t>::max()})
    keep_most_contributing(cloud, count, {}, {}, threads);
  EXPECT_EQ(cloud.positions, positions);
  keep_most_contributing(cloud, 1, {test::front_camera(16, 16, 2)}, {}, threads);
  EXPECT_EQ(cloud.size(), 1U);
}

}  // namespace
}  // namespace fluxgs::cli
