// Camera animations of SuperSplat: what they say, and what strangers may write instead.
#include "fluxgs/io/camera_track.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace fluxgs {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json settings() {
  return {{"version", 2},
          {"background", {{"color", {0, 0, 0}}}},
          {"animTracks",
           {{{"name", "cameraAnim"},
             {"duration", 4},
             {"frameRate", 30},
             {"loopMode", "repeat"},
             {"interpolation", "spline"},
             {"smoothness", 0.5},
             {"keyframes",
              {{"times", {0, 30, 90}},
               {"values",
                {{"position", {1, 2, 3, 4, 5, 6, 7, 8, 9}},
                 {"target", {0, 0, 0, 0, 1, 0, 0, 0, 1}},
                 {"fov", {60, 70, 80}}}}}}}}}};
}

Expected<CameraTrack> read(const std::string& text) {
  return read_supersplat_track(std::as_bytes(std::span(text)), "path.json");
}

std::string error_of(const std::string& text) {
  const auto track = read(text);
  return track ? "no error" : track.error().message();
}

/// The error after a change of the track.
std::string error_with(const std::string& pointer, const json& value) {
  json root = settings();
  root["animTracks"][0][json::json_pointer(pointer)] = value;
  return error_of(root.dump());
}

std::string error_without(const std::string& group, const std::string& key) {
  json root = settings();
  root["animTracks"][0][json::json_pointer(group)].erase(key);
  return error_of(root.dump());
}

TEST(CameraTrack, IsReadInTheFrameOfTheScene) {
  const auto track = read(settings().dump());
  ASSERT_TRUE(track) << track.error().message();
  ASSERT_EQ(track->keys.size(), 3U);
  EXPECT_EQ(track->keys[1].position, glm::dvec3(-4, -5, 6)) << "half a turn about z";
  EXPECT_EQ(track->keys[1].target, glm::dvec3(0, -1, 0));
  EXPECT_EQ(track->keys[1].seconds, 1);
  EXPECT_EQ(track->keys[2].seconds, 3);
  EXPECT_NEAR(track->keys[1].fov, 70 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(track->seconds, 4);
  EXPECT_EQ(track->smoothness, 0.5);
  EXPECT_EQ(track->end, CameraTrack::End::repeats);
}

TEST(CameraTrack, OldFilesHaveOneFieldOfViewAndTimesInSeconds) {
  json root = settings();
  root.erase("version");
  root["camera"] = {{"fov", 50}};
  json& track = root["animTracks"][0];
  track.erase("frameRate");
  track.erase("smoothness");
  track["keyframes"]["values"].erase("fov");
  track["keyframes"]["times"] = {0, 1.5, 3};
  track["loopMode"] = "pingpong";
  const auto old = read(root.dump());
  ASSERT_TRUE(old) << old.error().message();
  EXPECT_EQ(old->keys[1].seconds, 1.5);
  EXPECT_NEAR(old->keys[2].fov, 50 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(old->smoothness, 0) << "straight lines, as they were drawn then";
  EXPECT_EQ(old->end, CameraTrack::End::returns);
  root.erase("camera");
  EXPECT_NEAR(read(root.dump())->keys[0].fov, 60 * std::numbers::pi / 180, 1e-12);
}

TEST(CameraTrack, SaysInOneLineWhatIsWrong) {
  EXPECT_THAT(error_of(""), HasSubstr("path.json: is not JSON"));
  EXPECT_THAT(error_of("[1, 2]"), HasSubstr("expected an object"));
  EXPECT_THAT(error_of("{\"animTracks\": [{\"duration\": NaN}]}"), HasSubstr("is not JSON"));
  EXPECT_THAT(error_of("{}"), HasSubstr("has no camera animation"));
  EXPECT_THAT(error_of(R"({"animTracks": []})"), HasSubstr("has no camera animation"));
  EXPECT_THAT(error_of(R"({"version": 7, "animTracks": [{}]})"),
              HasSubstr("version: is 7; expected 1 or 2"));
  EXPECT_THAT(error_of(R"({"animTracks": [5]})"), HasSubstr("keyframes.times: expected a list"));
  EXPECT_THAT(error_without("/keyframes", "times"), HasSubstr("keyframes.times"));
  EXPECT_THAT(error_without("/keyframes/values", "target"),
              HasSubstr("keyframes.values.target: is missing; expected 9 numbers"));
  EXPECT_THAT(error_with("/keyframes/values/position", json::array({1, 2})),
              HasSubstr("has 2 numbers; expected 9"));
  EXPECT_THAT(error_with("/keyframes/values/position/4", nullptr),
              HasSubstr("animTracks[0].keyframes.values.position[4]: is missing"))
      << "how other writers write NaN";
  EXPECT_THAT(error_with("/keyframes/values/target/1", 1e30), HasSubstr("target[1]: is 1e+30"));
  EXPECT_THAT(error_with("/keyframes/values/fov/0", 0), HasSubstr("fov[0]: is 0; expected"));
  EXPECT_THAT(error_with("/keyframes/times/2", 30), HasSubstr("times[2]: is 30; expected a later"));
  EXPECT_THAT(error_with("/keyframes/times/2", -1), HasSubstr("times[2]: is -1"));
  EXPECT_THAT(error_with("/keyframes/times/0", "soon"), HasSubstr("times[0]: is \"soon\""));
  EXPECT_THAT(error_with("/duration", 0), HasSubstr("duration: is 0"));
  EXPECT_THAT(error_with("/duration", 1e9), HasSubstr("duration"));
  EXPECT_THAT(error_with("/frameRate", 0), HasSubstr("frameRate"));
  EXPECT_THAT(error_with("/smoothness", 2), HasSubstr("smoothness"));
  EXPECT_THAT(error_with("/loopMode", "never"), HasSubstr("loopMode: is \"never\""));
  EXPECT_THAT(error_with("/loopMode", 3), Not(HasSubstr("\n")));
}

TEST(CameraTrack, HugeCountsAreRefused) {
  EXPECT_THAT(error_with("/keyframes/times", std::vector<int>(kMaxTrackKeys + 1)),
              HasSubstr("expected a list of 1 to 10000 numbers"));
  EXPECT_THAT(error_of(std::string(100'000, '[')), HasSubstr("nested"));
  EXPECT_THAT(error_of("{\"a\": 1e999}"), HasSubstr("path.json"));
}

}  // namespace
}  // namespace fluxgs
