// The start view in a comment of .ply files.
#include <array>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fluxgs/io/compressed_ply.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/io/scene.h"
#include "support.h"
#include "support/temp_folder.h"

namespace fluxgs {
namespace {

using test::Bytes;

const InitialView kView{.position = {1.0 / 3, -2e-7, 3e8},
                        .orientation = glm::normalize(glm::dquat(0.9, 0.1, -0.3, 0.2)),
                        .fov_y = 0.7,
                        .up = glm::normalize(glm::dvec3(0.1, -1, 0.2)),
                        .image_width = 640,
                        .image_height = 480};

/// A .ply of a splat whose header has one more line.
Bytes with_line(const std::string& line) {
  const Bytes plain = *encode_ply(test::random_cloud(1, 0), "a.ply");
  std::string text(reinterpret_cast<const char*>(plain.data()), plain.size());
  text.insert(text.find("element vertex"), line + '\n');
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::optional<InitialView> start_of(const Bytes& file) {
  const auto scene = read_scene(file, "a.ply");
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? scene->start : std::nullopt;
}

void expect_same(const std::optional<InitialView>& view, const InitialView& expected) {
  ASSERT_TRUE(view);
  EXPECT_EQ(view->position, expected.position);
  EXPECT_EQ(view->orientation, expected.orientation);
  EXPECT_EQ(view->fov_y, expected.fov_y);
  EXPECT_EQ(view->up, expected.up);
  EXPECT_EQ(view->image_width, expected.image_width);
  EXPECT_EQ(view->image_height, expected.image_height);
}

TEST(PlyView, ComesBackToTheBit) {
  const SplatCloud cloud = test::random_cloud(300, 1);
  expect_same(start_of(*encode_ply(cloud, "a.ply", kView)), kView);
  expect_same(start_of(*encode_compressed_ply(cloud, "a.ply", kView)), kView);
  InitialView unsized = kView;
  unsized.image_width = unsized.image_height = 0;
  expect_same(start_of(*encode_ply(cloud, "a.ply", unsized)), unsized);
  EXPECT_FALSE(start_of(*encode_ply(cloud, "a.ply")));
  EXPECT_FALSE(start_of(*encode_compressed_ply(cloud, "a.ply")));
}

TEST(PlyView, IsWrittenByEveryFormatThatHoldsOne) {
  const test::TempFolder folder;
  const SplatCloud cloud = test::random_cloud(300, 1);
  WriteOptions options;
  options.start = kView;
  for (const char* name : {"a.ply", "a.compressed.ply", "a.glb", "a.spz", "a.sog", "a.splat"}) {
    ASSERT_TRUE(write_scene(folder / name, cloud, options)) << name;
    const auto scene = read_scene(folder / name);
    ASSERT_TRUE(scene) << name;
    const std::string extension = std::filesystem::path(name).extension().string();
    EXPECT_EQ(scene->start.has_value(), extension == ".ply" || extension == ".glb") << name;
  }
}

TEST(PlyView, TheLastSoundOneCounts) {
  const std::string view = "comment StartView: position 1 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 1";
  const std::string other =
      "comment StartView: position 4 5 6 orientation 1 0 0 0 fov_y 1 up 0 0 1";
  const auto start = start_of(with_line(view + "\n" + other + "\ncomment StartView: soon"));
  ASSERT_TRUE(start);
  EXPECT_EQ(start->position, glm::dvec3(4, 5, 6));
  EXPECT_EQ(start->up, glm::dvec3(0, 0, 1));
  EXPECT_TRUE(start_of(with_line(view + "  image_size  64\t48 ")));
}

TEST(PlyView, WhatIsNoViewIsAComment) {
  const std::string begin = "comment StartView: position ";
  for (const char* rest : {
           "",
           "1 2 3",
           "1 2 3 orientation 1 0 0 0 fov_y 1 up 0 0",
           "1 2 x orientation 1 0 0 0 fov_y 1 up 0 0 1",
           "nan 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 1",
           "1e999 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 1",
           "1 2 3 orientation 2 0 0 0 fov_y 1 up 0 0 1",
           "1 2 3 orientation 1 0 0 0 fov_y 4 up 0 0 1",
           "1 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 0",
           "1 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 1 more",
           "1 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 1 image_size 1",
           "1 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 1 image_size -1 1",
           "1 2 3 orientation 1 0 0 0 fov_y 1 up 0 0 1 image_size 99999999999 1",
       })
    EXPECT_FALSE(start_of(with_line(begin + rest))) << rest;
}

TEST(PlyView, AViewThatIsNotSoundIsLeftOut) {
  InitialView view = kView;
  view.up = {0, 0, 0};
  EXPECT_FALSE(start_of(*encode_ply(test::random_cloud(1, 0), "a.ply", view)));
}

}  // namespace
}  // namespace fluxgs
