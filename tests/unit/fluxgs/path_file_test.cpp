// Camera paths from files, and their frames.
#include "tools/fluxgs/cameras/path_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include <glm/geometric.hpp>

#include "run_command.h"
#include "some_track.h"

namespace fluxgs::cli {
namespace {

constexpr ImageSize kSize{64, 36};

TEST(PathFile, ListsOfCamerasAreGoneThroughInOrder) {
  const test::TempFolder folder;
  std::ofstream(folder / "cameras.json") << R"([
    {"name":"a","position":[0,0,-4],"target":[0,0,0],"up":[0,-1,0],"fovY":50},
    {"name":"b","position":[4,0,0],"target":[0,0,0],"up":[0,-1,0],"fovY":50},
    {"name":"c","position":[0,-1,4],"target":[0,0,0],"up":[0,-1,0],"fovY":50}])";
  const auto path = path_from_file(folder / "cameras.json");
  ASSERT_TRUE(path) << path.error().message();
  EXPECT_EQ(path->seconds, 6);
  const auto cameras = cameras_along(*path, 10, kSize);
  ASSERT_TRUE(cameras);
  ASSERT_EQ(cameras->size(), 61U) << "both ends";
  EXPECT_LT(glm::distance(cameras->front().center(), glm::dvec3(0, 0, -4)), 1e-6);
  EXPECT_LT(glm::distance(cameras->back().center(), glm::dvec3(0, -1, 4)), 1e-4);
  EXPECT_EQ(cameras->at(7).name, "007");
}

TEST(PathFile, APathThatRepeatsDoesNotShowItsBeginningTwice) {
  const test::TempFolder folder;
  std::ofstream(folder / "path.json") << test::some_track();
  const auto path = path_from_file(folder / "path.json");
  ASSERT_TRUE(path) << path.error().message();
  const auto cameras = cameras_along(*path, 4, kSize);
  ASSERT_TRUE(cameras);
  ASSERT_EQ(cameras->size(), 12U);
  EXPECT_GT(glm::distance(cameras->back().center(), cameras->front().center()), 0.1);
}

TEST(PathFile, TooManyFramesAreRefused) {
  const test::TempFolder folder;
  std::ofstream(folder / "path.json") << test::some_track();
  const auto cameras = cameras_along(*path_from_file(folder / "path.json"), 1e5, kSize);
  ASSERT_FALSE(cameras);
  EXPECT_NE(cameras.error().message().find("expected at most 10000"), std::string::npos);
}

TEST(PathFile, WhatIsNoPathIsSaid) {
  const test::TempFolder folder;
  EXPECT_FALSE(path_from_file(folder / "nothing.json"));
  for (const char* text : {"", "   ", "[]", "[5]", "{}", "what"}) {
    std::ofstream(folder / "path.json") << text;
    const auto path = path_from_file(folder / "path.json");
    ASSERT_FALSE(path) << text;
    EXPECT_NE(path.error().message().find("path.json"), std::string::npos);
  }
}

}  // namespace
}  // namespace fluxgs::cli
