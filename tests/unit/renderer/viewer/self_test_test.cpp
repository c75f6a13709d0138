#include "bench/self_test.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/gltf.h"
#include "tests/support/scenes.h"

namespace fluxgs {
namespace {

TEST(SelfTest, IsTheSameEveryTimeAndOfTheSceneOnly) {
  const SplatCloud cloud = test::random_cloud(2000, 2);
  const bench::SelfTest first = bench::self_test(cloud);
  EXPECT_EQ(first, bench::self_test(cloud));
  SplatCloud other = cloud;
  other.positions[7].x += 1e-3F;
  const bench::SelfTest changed = bench::self_test(other);
  EXPECT_NE(changed.decoded, first.decoded);
  EXPECT_NE(changed.sorted, first.sorted);
  EXPECT_NE(changed.projected, first.projected);
}

TEST(SelfTest, SpeaksJsonToOthers) {
  const auto file = *encode_glb(test::random_cloud(50, 1), "scene");
  char json[500];
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  const std::size_t length = fluxgs_self_test(bytes, file.size(), json, sizeof json);
  EXPECT_EQ(length, std::string(json).size());
  EXPECT_EQ(nlohmann::json::parse(json)["splats"], 50);
  EXPECT_EQ(std::string(json), bench::to_json(bench::self_test(read_glb(file, "")->cloud)));
  fluxgs_self_test(bytes, 10, json, sizeof json);
  EXPECT_TRUE(nlohmann::json::parse(json).contains("error"));
  fluxgs_self_test(nullptr, 0, json, sizeof json);
  EXPECT_TRUE(nlohmann::json::parse(json).contains("error"));
  char cut[5];
  EXPECT_GT(fluxgs_self_test(bytes, file.size(), cut, sizeof cut), 5U);
  EXPECT_EQ(std::string(cut).size(), 4U);
  EXPECT_EQ(fluxgs_self_test(bytes, file.size(), nullptr, 0), length);
}

}  // namespace
}  // namespace fluxgs
