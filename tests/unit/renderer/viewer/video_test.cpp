// The frames of a video: each one of the path, in order, once, at its time.
#include "viewer/video.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace fluxgs::viewer {
namespace {

const VideoPlan kPlan{.width = 64, .height = 36, .fps = 30};

camera::CameraPath path(camera::PathEnd end = camera::PathEnd::repeats) {
  const glm::dvec3 up(0, -1, 0);
  camera::CameraPath path =
      camera::orbit_path(camera::view_between({0, -1, -4}, {0, 0, 0}, up, 0.9), up, 2);
  path.end = end;
  return path;
}

/// An encoder that only writes down.
struct Recorder {
  std::vector<camera::ViewState> views = {};
  std::vector<std::int64_t> times = {};
  std::vector<int> asked = {};
  int stops_at = -1, fails_at = -1;

  Expected<RunResult> record(const camera::CameraPath& of, const VideoPlan& plan = kPlan) {
    return make_frames(
        of, plan,
        [&](const camera::ViewState& view, std::int64_t nanoseconds) -> Expected<void> {
          if (static_cast<int>(views.size()) == fails_at) return fail("encoder", "", "is gone");
          views.push_back(view);
          times.push_back(nanoseconds);
          return {};
        },
        [&](int done, int all) {
          EXPECT_EQ(all, frame_count(of, plan.fps));
          asked.push_back(done);
          return done != stops_at;
        });
  }
};

TEST(Video, HasEveryFrameOfThePathOnceInOrderAtItsTime) {
  for (const double fps : {24.0, 30.0, 60.0}) {
    Recorder recorder;
    const VideoPlan plan{.width = 64, .height = 36, .fps = fps};
    const auto result = recorder.record(path(), plan);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->stopped, "");
    const auto frames = static_cast<std::size_t>(2 * fps);
    ASSERT_EQ(recorder.views.size(), frames);
    for (std::size_t i = 0; i < frames; ++i) {
      const double seconds = static_cast<double>(i) / fps;
      EXPECT_EQ(recorder.times[i], std::llround(1e9 * seconds));
      const camera::ViewState view = camera::view_at(path(), seconds, {64, 36});
      EXPECT_EQ(recorder.views[i].target, view.target);
      EXPECT_EQ(recorder.views[i].orientation, view.orientation);
      EXPECT_EQ(recorder.asked[i], static_cast<int>(i));
    }
    EXPECT_EQ(recorder.asked.back(), static_cast<int>(frames)) << "all are done";
  }
}

TEST(Video, GoesThereAndBackWhereThePathReturns) {
  EXPECT_EQ(frame_count(path(), 30), 60);
  EXPECT_EQ(frame_count(path(camera::PathEnd::stops), 30), 60);
  EXPECT_EQ(frame_count(path(camera::PathEnd::returns), 30), 120);
  camera::CameraPath short_one = path();
  short_one.seconds = 1e-3;
  EXPECT_EQ(frame_count(short_one, 30), 1);
}

TEST(Video, StopsBetweenFrames) {
  Recorder recorder{.stops_at = 17};
  const auto result = recorder.record(path());
  ASSERT_TRUE(result);
  EXPECT_EQ(recorder.views.size(), 17U);
  EXPECT_NE(result->stopped, "");
}

TEST(Video, EndsWithTheFirstFrameThatFails) {
  Recorder recorder{.fails_at = 3};
  const auto result = recorder.record(path());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message(), "encoder: is gone");
  EXPECT_EQ(recorder.views.size(), 3U);
}

}  // namespace
}  // namespace fluxgs::viewer
