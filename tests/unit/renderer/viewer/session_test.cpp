// Scenes, settings and images of a viewer on its own thread.
#include "unit/renderer/viewer/session_fixture.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "camera/initial_view.h"
#include "fluxgs/io/gltf.h"
#include "tests/support/scenes.h"
#include "tools/reference/reference_renderer.h"

namespace fluxgs::viewer {
namespace {

using namespace std::chrono_literals;
using namespace session_test;
using testing::HasSubstr;

Image<std::uint8_t> reference_image() {
  const SceneFile file = *read_glb(file_with_start(), "scene");
  const auto n = camera::initial_navigation(file.cloud, file.start, {kWidth, kHeight});
  RenderOptions options;
  options.near_plane = n.units.near_plane;
  const ReferenceImage image =
      render_reference(file.cloud, camera::camera_of(n.view, kWidth, kHeight), options);
  Image<std::uint8_t> result(kWidth, kHeight, 4);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        result.at(x, y)[c] = static_cast<std::uint8_t>(
            std::lround(255 * std::clamp(image.color.at(x, y)[c], 0.0, 1.0)));
  return result;
}

TEST_P(SessionTest, ShowsASceneFromItsStart) {
  ASSERT_TRUE(load(file_with_start()));
  const SessionState state = session_->state();
  EXPECT_EQ(state.error, "");
  EXPECT_TRUE(state.has_scene);
  EXPECT_EQ(state.contexts, 1);
  EXPECT_GT(state.first_frame_ms, 0);
  EXPECT_GT(session_->frame_work(), 0ns);
  EXPECT_GT(session_->drawing_thread(), 0);
  EXPECT_NE(session_->drawing_thread(), ::gettid());
  EXPECT_EQ(state.stats.splats, 400U);
  EXPECT_EQ(state.stats.width, kWidth);
  EXPECT_TRUE(nlohmann::json::parse(session_->driver()).contains("renderer"));
  EXPECT_GT(psnr(image(), reference_image()), 50);
}

TEST_P(SessionTest, StandsStillWhenNothingMoves) {
  ASSERT_TRUE(load(file_with_start()));
  image();
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.stats.frames_per_second == 0; }));
}

TEST_P(SessionTest, NoFrameIsWantedAtRest) {
  EXPECT_LT(comes_to_rest_after([] {}), 60) << "without a scene";
  ASSERT_TRUE(load(file_with_start()));
  EXPECT_LT(comes_to_rest_after([] {}), 60);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(session_->frame(time_ += 1.0 / 60));
  EXPECT_GT(comes_to_rest_after([this] { session_->flip_up(); }), 1);
  session_->surface_destroyed();
  EXPECT_LT(comes_to_rest_after([] {}), 60) << "without a window";
  const auto before = session_->state().stats.splats;
  session_->surface_created(this);
  session_->load(file_of(*encode_glb(test::random_cloud(100, 1, 3), "scene")), "other.glb", {});
  ASSERT_TRUE(run_until([&](const SessionState& s) { return s.stats.splats != before; }));
}

TEST_P(SessionTest, ImagesAreSharpAndThumbnailsSmall) {
  settings_.scale = 0;
  session_->set(settings_);
  session_->set_heat({.status = 2});
  ASSERT_TRUE(load(file_with_start()));
  const auto whole = session_->image();
  ASSERT_TRUE(whole);
  EXPECT_EQ(session_->state().stats.scale, 0.7) << "heat holds at rest, too";
  const auto small = session_->image(24);
  ASSERT_TRUE(small);
  EXPECT_EQ(small->width, 24);
  EXPECT_EQ(small->height, 16);
  // Each of its pixels is the mean of 4x4
  Image<std::uint8_t> mean(24, 16, 4);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int k = 0; k < 16; ++k) sum += whole->at(4 * x + k % 4, 4 * y + k / 4)[c];
        mean.at(x, y)[c] = static_cast<std::uint8_t>((sum + 8) / 16);
      }
  EXPECT_GT(psnr(*small, mean), 40);
  EXPECT_EQ(session_->image(1000)->width, kWidth);
  const std::uint64_t number = session_->state().shown;
  EXPECT_TRUE(session_->image(24, number));
  EXPECT_FALSE(session_->image(24, number + 1)) << "of another scene";
}

TEST_P(SessionTest, ASavedViewIsKeptOverTheEndOfTheProcess) {
  ASSERT_TRUE(load(file_with_start()));
  session_->touch(TouchPhase::down, 0, {{0, {50, 30}}}, 1);
  session_->touch(TouchPhase::moved, 0, {{0, {80, 40}}}, 1.1);
  session_->touch(TouchPhase::cancelled, 0, {}, 2);
  session_->flip_up();
  const auto before = image();
  const auto saved = session_->saved_view();
  ASSERT_TRUE(saved);
  begin();
  ASSERT_TRUE(load(file_with_start(), saved));
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_TRUE(session_->state().flipped);
  const auto broken = [&](auto&& change) {
    SavedView view = *saved;
    change(view);
    return view;
  };
  for (const SavedView& view : {broken([](SavedView& v) { v.view.distance = std::nan(""); }),
                                broken([](SavedView& v) { v.view.target.y = std::nan(""); }),
                                broken([](SavedView& v) { v.view.orientation = {0, 0, 0, 0}; }),
                                broken([](SavedView& v) { v.up.x = std::nan(""); }),
                                broken([](SavedView& v) { v.view.fov = 4; })}) {
    begin();
    ASSERT_TRUE(load(file_with_start(), view));
    EXPECT_GT(psnr(image(), reference_image()), 50) << "no view, so the initial one";
  }
}

// A shell that asked for several, and cancelled some, knows by the number which it sees.
TEST_P(SessionTest, TheSceneThatIsShownIsKnownByItsNumber) {
  EXPECT_EQ(session_->state().shown, 0U);
  const auto begin_loading = [&](std::uint32_t seed) {
    return session_->load(file_of(file_with_start(seed)), "scene.glb", {});
  };
  const auto first = begin_loading(1);
  ASSERT_TRUE(run_until([&](const SessionState& s) { return s.shown == first; }));
  const auto second = begin_loading(2);
  EXPECT_NE(second, first);
  session_->cancel_loading();
  image();
  EXPECT_EQ(session_->state().shown, first);
  const auto third = begin_loading(3);
  ASSERT_TRUE(run_until([&](const SessionState& s) { return s.shown == third; }));
}

TEST_P(SessionTest, LessMemoryThanTheSceneTakesLeavesOutSplats) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  const ViewerStats all = session_->state().stats;
  ASSERT_GT(all.memory, 0U);
  settings_.memory = all.memory;
  session_->set(settings_);
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_EQ(session_->state().stats.shown, all.splats);
  settings_.memory = all.memory / 4;
  session_->set(settings_);
  image();
  const ViewerStats fewer = session_->state().stats;
  EXPECT_LT(fewer.shown, all.splats);
  EXPECT_GT(fewer.shown, 0U);
  EXPECT_LE(fewer.memory, *settings_.memory);
}

TEST_P(SessionTest, ABadFileLeavesTheSceneBefore) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->load(file_of(std::vector<std::byte>(100)), "bad.glb", {});
  ASSERT_TRUE(
      run_until([](const SessionState& s) { return s.loading.phase == LoadPhase::failed; }));
  EXPECT_THAT(session_->state().loading.error, HasSubstr("bad.glb: format"));
  EXPECT_GT(psnr(image(), before), 50);
  ASSERT_TRUE(load(file_with_start(2)));
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.loading.phase == LoadPhase::ready; }));
  EXPECT_LT(psnr(image(), before), 40) << "another scene";
}

TEST_P(SessionTest, SettingsChangeWhatIsDrawn) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  settings_.sorter = SorterChoice::gpu;
  session_->set(settings_);
  EXPECT_GT(psnr(image(), before), 45) << "the other sorter";
  settings_.scale = 0.5;
  session_->set(settings_);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.stats.width == kWidth / 2; }));
  EXPECT_LT(psnr(image(), before), 45);
  settings_.scale = 1;
  settings_.max_splats = 100;
  session_->set(settings_);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.stats.shown == 100; }));
  settings_.max_splats = 0;
  settings_.sh_degree = 0;
  session_->set(settings_);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.stats.shown == 400; }));
  EXPECT_LT(psnr(image(), before), 45);
}

TEST_P(SessionTest, EndsInTheMiddleOfAnything) {
  session_->load(file_of(file_with_start()), "scene.glb", {});
  session_.reset();
  begin();
  ASSERT_TRUE(load(file_with_start()));
  session_->start_benchmark({.protocol = {.frames = 100'000}});
  std::this_thread::sleep_for(50ms);
  session_.reset();
}

FLUXGS_GL_TEST_SUITE(SessionTest);

}  // namespace
}  // namespace fluxgs::viewer
