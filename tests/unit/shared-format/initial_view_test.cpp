// Where a scene is looked at from first: cameras of glTF.
#include "fluxgs/io/initial_view.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/scene.h"
#include "glb_support.h"
#include "support.h"

namespace fluxgs {
namespace {

using nlohmann::json;
using test::Bytes;

const InitialView kView{.position = {1, -2, 3},
                        .orientation = glm::normalize(glm::dquat(0.9, 0.1, -0.3, 0.2)),
                        .fov_y = 0.7,
                        .up = glm::normalize(glm::dvec3(0.1, -1, 0.2))};

Bytes scene_file() { return *encode_glb(test::random_cloud(20, 1), "a.glb"); }

/// A scene of one splat whose JSON has these cameras and nodes behind its own.
Bytes with_nodes(const json& cameras, const json& nodes) {
  const Bytes file = scene_file();
  json document = json::parse(test::json_of(file));
  document["cameras"] = cameras;
  json& shown = document["scenes"][0]["nodes"];
  for (const json& node : nodes) {
    shown.push_back(document["nodes"].size());
    document["nodes"].push_back(node);
  }
  return test::make_glb(document.dump(), test::bin_of(file));
}

const json kCameras = {{{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}}};

std::optional<InitialView> start_of(const Bytes& file) {
  const auto scene = read_scene(file, "a.glb");
  EXPECT_TRUE(scene) << scene.error().message();
  if (!scene) return std::nullopt;
  EXPECT_EQ(scene->cloud.size(), 20U) << "the splats are all there";
  return scene->start;
}

double angle_between(const glm::dquat& a, const glm::dquat& b) {
  return 2 * std::acos(std::min(std::abs(glm::dot(a, b)), 1.0));
}

TEST(InitialView, AddsNoMoreThanSaid) {
  const Bytes plain = scene_file();
  const double long_number = -1234567.8901234567e-300;
  const InitialView view{.position = glm::dvec3(long_number),
                         .orientation = kView.orientation,
                         .fov_y = 0.12345678901234567,
                         .up = kView.up};
  const auto file = with_initial_view(plain, view, "a.glb");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_LE(file->size(), plain.size() + kMaxInitialViewBytes);
}

TEST(InitialView, IsWrittenAndReadAgain) {
  for (const Bytes& file :
       {scene_file(), *encode_compact_glb(test::random_cloud(20, 1), {}, "c")}) {
    EXPECT_FALSE(start_of(file));
    const auto with = with_initial_view(file, kView, "a.glb");
    ASSERT_TRUE(with) << with.error().message();
    const auto read = start_of(*with);
    ASSERT_TRUE(read);
    EXPECT_LT(glm::distance(read->position, kView.position), 1e-12);
    EXPECT_LT(angle_between(read->orientation, kView.orientation), 1e-7);
    EXPECT_DOUBLE_EQ(read->fov_y, kView.fov_y);
    EXPECT_LT(glm::distance(read->up, kView.up), 1e-12);
    EXPECT_EQ(read_scene(*with, "")->cloud.positions, read_scene(file, "")->cloud.positions);
  }
}

TEST(InitialView, ComesBeforeOtherCameras) {
  const Bytes other = with_nodes(kCameras, {{{"camera", 0}, {"translation", {9, 9, 9}}}});
  const auto read = start_of(*with_initial_view(other, kView, "a.glb"));
  ASSERT_TRUE(read);
  EXPECT_DOUBLE_EQ(read->fov_y, kView.fov_y);
}

// glTF 2.0, section 3.10.2: a camera looks along its −z, up is its y; the frame has y up. A cloud
// has y down and z forward, turned by half a turn about z.
TEST(InitialView, OfGltfsOwnConvention) {
  const auto read = start_of(with_nodes(kCameras, {{{"camera", 0}, {"translation", {1, 2, 3}}}}));
  ASSERT_TRUE(read);
  EXPECT_LT(glm::distance(read->position, glm::dvec3(-1, -2, 3)), 1e-12);
  EXPECT_LT(glm::distance(read->orientation * glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)), 1e-12);
  EXPECT_LT(glm::distance(read->orientation * glm::dvec3(0, 1, 0), glm::dvec3(0, 1, 0)), 1e-12);
  EXPECT_LT(glm::distance(read->orientation * glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0)), 1e-12);
  EXPECT_EQ(read->up, glm::dvec3(0, -1, 0));
}

TEST(InitialView, OfANodeWithAMatrix) {
  // A quarter turn about y, twice as large
  const json matrix = {0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 5, 6, 7, 1};
  const json quarter = {0, std::sqrt(0.5), 0, std::sqrt(0.5)};
  const auto read = start_of(with_nodes(kCameras, {{{"camera", 0}, {"matrix", matrix}}}));
  const auto same = start_of(
      with_nodes(kCameras, {{{"camera", 0}, {"translation", {5, 6, 7}}, {"rotation", quarter}}}));
  ASSERT_TRUE(read && same);
  EXPECT_LT(glm::distance(read->position, same->position), 1e-12);
  EXPECT_LT(angle_between(read->orientation, same->orientation), 1e-7);
}

TEST(InitialView, WhatIsOddAboutACameraIsNoError) {
  const json orthographic = {{{"type", "orthographic"}, {"orthographic", {{"xmag", 1}}}}};
  const json wide = {{{"type", "perspective"}, {"perspective", {{"yfov", 4.0}}}}};
  const json text = {{{"type", "perspective"}, {"perspective", {{"yfov", "1"}}}}};
  const json here = {{{"camera", 0}}};
  for (const json& cameras : {orthographic, wide, text, json(7), json::array(), json::object()})
    EXPECT_FALSE(start_of(with_nodes(cameras, here))) << cameras.dump();
  const json skewed = {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const json mirrored = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  for (const json& node :
       {json{{"camera", 1}}, json{{"camera", -1}}, json{{"camera", "0"}},
        json{{"camera", 0}, {"matrix", skewed}}, json{{"camera", 0}, {"matrix", mirrored}},
        json{{"camera", 0}, {"translation", {1e300, 0, 0}}},
        json{{"camera", 0}, {"rotation", {0, 0, 0, 0}}}})
    EXPECT_FALSE(start_of(with_nodes(kCameras, json::array({node})))) << node.dump();
  const auto odd_up =
      start_of(with_nodes(kCameras, {{{"camera", 0}, {"extras", {{"up", {0, 0, 0}}}}}}));
  ASSERT_TRUE(odd_up);
  EXPECT_EQ(odd_up->up, glm::dvec3(0, -1, 0));
}

TEST(InitialView, RefusesWhatCannotBeWritten) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  InitialView bad[] = {kView, kView, kView, kView};
  bad[0].position.x = kNan;
  bad[1].up = {0, 0, 0};
  bad[2].fov_y = 0;
  bad[3].orientation = glm::dquat(0, 0, 0, 0);
  for (const InitialView& view : bad) EXPECT_FALSE(with_initial_view(scene_file(), view, "a.glb"));
  EXPECT_FALSE(with_initial_view(test::bytes_of("no glb"), kView, "a.glb"));
  const auto no_scene =
      with_initial_view(test::make_glb(R"({"asset":{"version":"2.0"}})"), kView, "a.glb");
  ASSERT_FALSE(no_scene);
  EXPECT_EQ(no_scene.error().field, "scenes");
  const auto odd = with_initial_view(
      test::make_glb(R"({"asset":{"version":"2.0"},"scenes":[{}],"cameras":3})"), kView, "a.glb");
  ASSERT_FALSE(odd);
  EXPECT_EQ(odd.error().field, "cameras");
}

}  // namespace
}  // namespace fluxgs
