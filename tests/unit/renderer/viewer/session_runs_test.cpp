// Videos and benchmarks that a viewer makes on its own thread.
#include "unit/renderer/viewer/session_fixture.h"

#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "camera/orbit.h"

namespace fluxgs::viewer {
namespace {

using namespace std::chrono_literals;
using namespace session_test;
using testing::HasSubstr;

using SessionRunsTest = SessionTest;

/// An encoder behind the screen.
class FilmingScreen : public WrappedScreen {
 public:
  FilmingScreen(host::HostGl gl, std::vector<std::int64_t>& times)
      : WrappedScreen(gl), times_(times) {}
  Expected<void> begin_video(void* window) override {
    return window != nullptr ? Expected<void>() : fail("video", "", "no window");
  }
  Expected<void> video_frame(const std::function<void()>&, std::int64_t nanoseconds) override {
    times_.push_back(nanoseconds);
    return {};
  }

 private:
  std::vector<std::int64_t>& times_;
};

TEST_P(SessionRunsTest, MakesAVideoAndDrawsOn) {
  std::vector<std::int64_t> times;
  begin_on(std::make_unique<FilmingScreen>(GetParam(), times));
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  const SavedView start = *session_->saved_view();
  session_->set_path(camera::orbit_path(start.view, start.up, 1));
  session_->start_video(this, {.width = 80, .height = 48, .fps = 12});
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->video().running; }));
  const RunState state = session_->video();
  EXPECT_EQ(state.error, "");
  EXPECT_EQ(state.stopped, "");
  EXPECT_EQ(state.done, 12);
  ASSERT_EQ(times.size(), 12U);
  EXPECT_EQ(times[6], 500'000'000);
  EXPECT_GT(psnr(image(), before), 50) << "the window shows its own view again";
}

TEST_P(SessionRunsTest, AVideoCanBeStoppedAndLosesNothing) {
  std::vector<std::int64_t> times;
  begin_on(std::make_unique<FilmingScreen>(GetParam(), times));
  ASSERT_TRUE(load(file_with_start()));
  session_->start_video(this, {});
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->video().running; }));
  EXPECT_THAT(session_->video().error, HasSubstr("there is no camera path"));
  const SavedView start = *session_->saved_view();
  session_->set_path(camera::orbit_path(start.view, start.up, 1000));
  session_->start_video(this, {.width = 80, .height = 48});
  EXPECT_TRUE(run_until([this](const SessionState&) { return session_->video().done > 3; }));
  session_->surface_destroyed();  // does not wait for its end
  session_->stop_video("enough");
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->video().running; }));
  EXPECT_EQ(session_->video().stopped, "enough");
  session_->start_video(this, {.width = 80, .height = 48});
  EXPECT_TRUE(run_until([this](const SessionState&) { return session_->video().done > 3; }));
  session_->free_graphics();
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->video().running; }));
  EXPECT_THAT(session_->video().error, HasSubstr("no longer shown"));
}

TEST_P(SessionRunsTest, BenchmarksAndDrawsOn) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->start_benchmark(
      {.sizes = {{64, 48}, {32, 24}}, .protocol = {.warmup = 1, .frames = 3}});
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->benchmark().running; }));
  const RunState state = session_->benchmark();
  EXPECT_EQ(state.error, "");
  EXPECT_EQ(state.stopped, "");
  EXPECT_EQ(state.done, state.all);
  const auto rows = nlohmann::json::parse(state.rows);
  ASSERT_EQ(rows.size(), 8U) << "2 sizes, 2 sorters, still and moving";
  for (const auto& row : rows) {
    EXPECT_GT(row["draw_ms"]["median"].get<double>(), 0);
    EXPECT_GT(row["splats_drawn"].get<int>(), 0);
  }
  EXPECT_GT(psnr(image(), before), 50);
}

TEST_P(SessionRunsTest, ABenchmarkCanBeStopped) {
  ASSERT_TRUE(load(file_with_start()));
  session_->start_benchmark(
      {.sizes = {{64, 48}, {32, 24}}, .protocol = {.warmup = 1, .frames = 100'000}});
  EXPECT_TRUE(run_until([this](const SessionState&) { return session_->benchmark().done > 3; }));
  session_->surface_destroyed();  // does not wait for its end
  session_->stop_benchmark("a call");
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->benchmark().running; }));
  EXPECT_EQ(session_->benchmark().stopped, "a call");
  EXPECT_EQ(session_->benchmark().rows, "[]");
}

TEST_P(SessionRunsTest, WithoutASceneThereIsNothingToMeasure) {
  session_->start_benchmark({});
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->benchmark().running; }));
  EXPECT_THAT(session_->benchmark().error, HasSubstr("there is no scene"));
  EXPECT_FALSE(session_->image());
}

FLUXGS_GL_TEST_SUITE(SessionRunsTest);

}  // namespace
}  // namespace fluxgs::viewer
