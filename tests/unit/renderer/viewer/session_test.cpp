// The viewer on its own thread, with each implementation of GL behind it.
#include "viewer/session.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "camera/initial_view.h"
#include "camera/orbit.h"
#include "fluxgs/io/gltf.h"
#include "platform/host/offscreen_screen.h"
#include "tests/support/scenes.h"
#include "tools/reference/reference_renderer.h"

namespace fluxgs::viewer {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kWidth = 96, kHeight = 64;
constexpr host::HostGl kImplementations[] = {host::HostGl::egl, host::HostGl::osmesa,
                                             host::HostGl::angle};

int file_of(const std::vector<std::byte>& bytes) {
  std::FILE* file = std::tmpfile();
  std::fwrite(bytes.data(), 1, bytes.size(), file);
  std::fflush(file);
  const int descriptor = ::dup(::fileno(file));
  std::fclose(file);
  ::lseek(descriptor, 0, SEEK_SET);
  return descriptor;
}

const InitialView kStart{.position = {0, 0, -4}, .fov_y = 0.8};

SplatCloud scene(std::uint32_t seed = 1) { return test::random_cloud(400, 1, seed); }

std::vector<std::byte> file_with_start(std::uint32_t seed = 1) {
  return *with_initial_view(*encode_glb(scene(seed), "scene"), kStart, "scene");
}

class SessionTest : public testing::TestWithParam<host::HostGl> {
 protected:
  void SetUp() override {
    const auto context = host::HostContext::create(GetParam());
    if (!context) GTEST_SKIP() << context.error().message();
    settings_.scale = 1;
    begin();
  }

  void begin() { begin_on(host::make_offscreen_screen(GetParam())); }
  void begin_on(std::unique_ptr<Screen> screen) {
    session_ = std::make_unique<Session>(std::move(screen));
    session_->set(settings_);
    session_->surface_created(this);
    session_->surface_changed(kWidth, kHeight, 1);
  }

  /// Lets the display go on until something holds.
  bool run_until(const std::function<bool(const SessionState&)>& holds) {
    for (int i = 0; i < 3000; ++i) {
      session_->frame(time_ += 1.0 / 60);
      std::this_thread::sleep_for(5ms);
      if (holds(session_->state())) return true;
    }
    return false;
  }
  bool load(const std::vector<std::byte>& bytes, const std::optional<SavedView>& saved = {}) {
    session_->load(file_of(bytes), "scene.glb", {}, saved);
    return run_until([](const SessionState& s) { return s.drawn || !s.error.empty(); });
  }
  /// The image once everything has come to rest.
  Image<std::uint8_t> image() {
    for (int i = 0; i < 20; ++i) {
      session_->frame(time_ += 1.0 / 60);
      std::this_thread::sleep_for(5ms);
    }
    const auto taken = session_->image();
    EXPECT_TRUE(taken);
    return taken.value_or(Image<std::uint8_t>(kWidth, kHeight, 4));
  }

  /// How many frames of the display are wanted after something.
  int comes_to_rest_after(const std::function<void()>& something) {
    something();
    for (int frames = 0; frames < 600; ++frames) {
      if (!session_->frame(time_ += 1.0 / 60)) return frames;
      std::this_thread::sleep_for(5ms);
    }
    return 600;
  }

  std::unique_ptr<Session> session_;
  ViewerSettings settings_;
  double time_ = 0;
};

/// dB between two images of 8 bits.
double psnr(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  if (a.width != b.width || a.height != b.height) return 0;
  double sum = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double d = (double(a.at(x, y)[c]) - double(b.at(x, y)[c])) / 255;
        sum += d * d;
      }
  return -10 * std::log10(std::max(sum / (3.0 * a.width * a.height), 1e-12));
}

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

// Whoever sorts, a drag is movement: it has a rate, and a scale that holds the display's.
TEST_P(SessionTest, AFingerThatDragsIsMeasured) {
  constexpr auto kSlow = 30ms;  // no frame fits 60 a second: a lower scale must be tried
  for (const SorterChoice sorter : {SorterChoice::gpu, SorterChoice::cpu}) {
    settings_.sorter = sorter;
    settings_.scale = 0;
    session_->set(settings_);
    ASSERT_TRUE(load(file_with_start()));
    session_->touch(TouchPhase::down, 0, {{0, {50, 30}}}, time_);
    float x = 50;
    bool rated = false;
    const bool lower = run_until([&](const SessionState& s) {
      x = x < 90 ? x + 0.5F : 10;
      session_->touch(TouchPhase::moved, 0, {{0, {x, 30}}}, time_);
      std::this_thread::sleep_for(kSlow);
      rated = rated || s.stats.frames_per_second > 0;
      return rated && s.stats.scale < 1;
    });
    EXPECT_TRUE(lower) << rated;
    // Held still, there is time for every pixel
    EXPECT_TRUE(run_until([](const SessionState& s) {
      return s.stats.scale == 1 && s.stats.width == kWidth && s.stats.frames_per_second == 0;
    }));
    session_->touch(TouchPhase::up, 0, {{0, {x, 30}}}, time_ + 1);
  }
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

TEST_P(SessionTest, AFingerTurnsItAndResetLeadsBack) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->touch(TouchPhase::down, 0, {{0, {50, 30}}}, 1);
  session_->touch(TouchPhase::moved, 0, {{0, {80, 30}}}, 1.1);
  session_->touch(TouchPhase::up, 0, {{0, {80, 30}}}, 2);
  EXPECT_LT(psnr(image(), before), 30);
  session_->reset_view();
  ASSERT_TRUE(run_until([this](const SessionState&) { return time_ > 3; }));
  EXPECT_GT(psnr(image(), before), 50);
}

TEST_P(SessionTest, AViewThatWasLeftIsComeBackTo) {
  ASSERT_TRUE(load(file_with_start()));
  session_->touch(TouchPhase::down, 0, {{0, {50, 30}}}, 1);
  session_->touch(TouchPhase::moved, 0, {{0, {80, 30}}}, 1.1);
  session_->touch(TouchPhase::cancelled, 0, {}, 2);
  const auto before = image();
  const auto left = session_->saved_view();
  ASSERT_TRUE(left);
  session_->reset_view();
  session_->flip_up();
  session_->go_to(*left);
  ASSERT_TRUE(run_until([this](const SessionState&) { return time_ > 3; }));
  EXPECT_FALSE(session_->state().flipped);
  EXPECT_GT(psnr(image(), before), 50);
  SavedView broken = *left;
  broken.view.distance = std::nan("");
  session_->go_to(broken);
  EXPECT_GT(psnr(image(), before), 50) << "no view to go to";
}

TEST_P(SessionTest, FlippingTurnsItUpsideDown) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->flip_up();
  const auto flipped = image();
  EXPECT_TRUE(session_->state().flipped);
  Image<std::uint8_t> turned = before;  // half a turn in the image's plane
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      std::copy_n(before.at(kWidth - 1 - x, kHeight - 1 - y), 3, turned.at(x, y));
  EXPECT_GT(psnr(flipped, turned), 40);
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

TEST_P(SessionTest, TheWindowComesAndGoes) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->surface_destroyed();
  session_->flip_up();
  session_->flip_up();
  session_->surface_changed(40, 60, 3);
  session_->surface_created(this);
  EXPECT_EQ(image().width, 40) << "turned to portrait";
  session_->surface_changed(kWidth, kHeight, 1);
  EXPECT_GT(psnr(image(), before), 50);
  session_->surface_changed(0, 0, 0);
  session_->frame(time_ += 1);
  EXPECT_EQ(session_->state().error, "");
}

TEST_P(SessionTest, GraphicsThatWereFreedAreMadeAgain) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->surface_destroyed();
  session_->free_graphics();
  EXPECT_FALSE(session_->image());
  for (int i = 0; i < 200 && session_->state().stats.memory > 0; ++i)
    std::this_thread::sleep_for(5ms);
  EXPECT_EQ(session_->state().stats.memory, 0U);
  session_->surface_created(this);
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_GT(session_->state().stats.memory, 0U);
  EXPECT_EQ(session_->state().contexts, 1);
}

// The last frame of the display may be waiting still when the app is told to give back memory.
TEST_P(SessionTest, FramesOfBeforeDoNotMakeFreedGraphicsAgain) {
  ASSERT_TRUE(load(file_with_start()));
  for (int i = 0; i < 20; ++i) {
    session_->reset_view();
    session_->frame(time_ += 1.0 / 60);
    session_->free_graphics();
    EXPECT_FALSE(session_->image());
    EXPECT_FALSE(session_->image()) << "nor in the round after";
  }
  image();  // there is one
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

TEST_P(SessionTest, ALostContextIsMadeAgain) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->lose_context();
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.contexts == 2; }));
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_EQ(session_->state().error, "");
}

/// A screen whose context turns out to be lost when its window comes back.
class ForgetfulScreen final : public Screen {
 public:
  explicit ForgetfulScreen(std::unique_ptr<Screen> real) : real_(std::move(real)) {}
  Expected<gl::Api*> make_context() override { return real_->make_context(); }
  gl::Api* api() override { return real_->api(); }
  void attach(void* window) override {
    real_->attach(window);
    if (api() != nullptr) api()->lost = true;
  }
  void detach() override { real_->detach(); }
  bool has_window() const override { return real_->has_window(); }
  Expected<bool> present(const std::function<void()>& draw, int width, int height) override {
    return real_->present(draw, width, height);
  }

 private:
  std::unique_ptr<Screen> real_;
};

/// What a window does to images, and how many were to be shown in it.
struct WindowFaults {
  std::atomic<int> going = 0;       ///< so many of them are not shown: it is about to go
  std::atomic<bool> fails = false;  ///< all the time
  std::atomic<int> presented = 0;
};

/// A screen whose windows have faults.
class FaultyScreen final : public Screen {
 public:
  FaultyScreen(std::unique_ptr<Screen> real, WindowFaults& faults)
      : real_(std::move(real)), faults_(faults) {}
  Expected<gl::Api*> make_context() override { return real_->make_context(); }
  gl::Api* api() override { return real_->api(); }
  void attach(void* window) override { real_->attach(window); }
  void detach() override { real_->detach(); }
  bool has_window() const override { return real_->has_window(); }
  Expected<bool> present(const std::function<void()>& draw, int width, int height) override {
    ++faults_.presented;
    if (faults_.fails) return fail("EGL", "eglSwapBuffers", "failed with error 0x3003");
    if (faults_.going > 0) {
      --faults_.going;
      return false;
    }
    return real_->present(draw, width, height);
  }

 private:
  std::unique_ptr<Screen> real_;
  WindowFaults& faults_;
};

TEST_P(SessionTest, AImageThatAWindowDidNotShowIsShownByTheNextFrame) {
  WindowFaults faults;
  begin_on(std::make_unique<FaultyScreen>(host::make_offscreen_screen(GetParam()), faults));
  faults.going = 3;
  ASSERT_TRUE(load(file_with_start()));
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.drawn; }));
  EXPECT_EQ(faults.going, 0);
  EXPECT_GE(faults.presented, 4);
  EXPECT_EQ(session_->state().error, "");
  session_.reset();  // before the faults
}

TEST_P(SessionTest, AnotherWindowIsAnotherTry) {
  WindowFaults faults;
  begin_on(std::make_unique<FaultyScreen>(host::make_offscreen_screen(GetParam()), faults));
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  faults.fails = true;
  session_->reset_view();
  session_->surface_changed(kWidth, kHeight, 1);
  EXPECT_TRUE(run_until([](const SessionState& s) { return !s.error.empty(); }));
  EXPECT_FALSE(session_->state().has_scene);
  faults.fails = false;
  session_->surface_destroyed();
  session_->surface_created(this);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.has_scene && s.error.empty(); }));
  EXPECT_GT(psnr(image(), before), 50);
  session_.reset();  // before the faults
}

TEST_P(SessionTest, AContextThatIsLostWhileTheWindowIsAwayIsMadeAgain) {
  begin_on(std::make_unique<ForgetfulScreen>(host::make_offscreen_screen(GetParam())));
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->surface_destroyed();
  session_->surface_created(this);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.contexts == 2; }));
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_EQ(session_->state().error, "");
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

TEST_P(SessionTest, TheGyroscopeLooksAround) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  settings_.gyroscope = true;
  session_->set(settings_);
  const glm::dquat upright = glm::angleAxis(std::numbers::pi / 2, glm::dvec3(1, 0, 0));
  session_->turn({.rotation = upright, .seconds = 0});
  session_->turn({.rotation = upright, .seconds = 9});
  EXPECT_GT(psnr(image(), before), 40);
  session_->turn({.rotation = glm::angleAxis(0.3, glm::dvec3(0, 0, 1)) * upright, .seconds = 9.1});
  EXPECT_LT(psnr(image(), before), 30);
}

TEST_P(SessionTest, WhatBeginsToMoveIsDrawnHoweverLateTheDisplayAsks) {
  ASSERT_TRUE(load(file_with_start()));
  const SavedView home = *session_->saved_view();
  SavedView other = home;
  other.view = camera::orbit(other.view, {30, 0}, {kWidth, kHeight}, other.up);
  for (const SavedView& next : {other, home}) {
    EXPECT_LT(comes_to_rest_after([] {}), 300);
    session_->go_to(next);
    std::this_thread::sleep_for(100ms);  // the drawing thread has it, and no frame is asked for
    EXPECT_TRUE(session_->frame(time_ += 1.0 / 60));
    EXPECT_LT(comes_to_rest_after([] {}), 300);
    const SavedView now = *session_->saved_view();
    EXPECT_LT(glm::distance(camera::eye(now.view), camera::eye(next.view)), 1e-9);
  }
}

TEST_P(SessionTest, DriftsUntilItIsTouched) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  EXPECT_EQ(session_->state().motion, Motion::none);
  session_->drift(true);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.motion == Motion::drift; }));
  for (int i = 0; i < 120; ++i) {
    EXPECT_TRUE(session_->frame(time_ += 1.0 / 60)) << "frames are wanted";
    std::this_thread::sleep_for(2ms);
  }
  const std::vector<Finger> finger{{0, {48, 32}}};
  const int frames =
      comes_to_rest_after([&] { session_->touch(TouchPhase::down, 0, finger, time_); });
  EXPECT_LT(frames, 300);
  EXPECT_EQ(session_->state().motion, Motion::none);
  session_->drift(true);
  EXPECT_LT(comes_to_rest_after([] {}), 300) << "not under a finger";
  EXPECT_LT(psnr(*session_->image(), before), 45);
}

TEST_P(SessionTest, PlaysAPathUntilItIsTouched) {
  ASSERT_TRUE(load(file_with_start()));
  session_->play(true);
  image();
  EXPECT_EQ(session_->state().motion, Motion::none) << "there is no path yet";
  const SavedView start = *session_->saved_view();
  EXPECT_EQ(session_->set_path(camera::orbit_path(start.view, start.up, 5)), 5);
  session_->play(true);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.motion == Motion::path; }));
  for (int i = 0; i < 90; ++i) {
    EXPECT_TRUE(session_->frame(time_ += 1.0 / 60)) << "frames are wanted";
    std::this_thread::sleep_for(2ms);
  }
  session_->touch(TouchPhase::down, 0, {{0, {48, 32}}}, time_);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.motion == Motion::none; }));
  const SavedView now = *session_->saved_view();
  EXPECT_GT(glm::distance(camera::eye(now.view), camera::eye(start.view)), 0.1);
}

TEST_P(SessionTest, GoesToASavedViewButNotToOneThatIsNone) {
  ASSERT_TRUE(load(file_with_start()));
  SavedView other = *session_->saved_view();
  other.view = camera::orbit(other.view, {30, 10}, {kWidth, kHeight}, other.up);
  session_->go_to(other);
  const auto arrived = [&](const SessionState&) {
    const SavedView now = *session_->saved_view();
    return glm::distance(camera::eye(now.view), camera::eye(other.view)) < 1e-9;
  };
  EXPECT_TRUE(run_until(arrived));
  SavedView none = other;
  none.view.distance = NAN;
  session_->go_to(none);
  other.view.distance *= 2;
  other.up = -other.up;
  EXPECT_LT(comes_to_rest_after([] {}), 300);
  EXPECT_FALSE(session_->state().flipped);
  session_->go_to(other);
  EXPECT_TRUE(run_until(arrived));
  EXPECT_TRUE(session_->state().flipped);
}

/// An encoder behind the screen.
class FilmingScreen : public Screen {
 public:
  FilmingScreen(host::HostGl gl, std::vector<std::int64_t>& times)
      : screen_(host::make_offscreen_screen(gl)), times_(times) {}
  Expected<gl::Api*> make_context() override { return screen_->make_context(); }
  gl::Api* api() override { return screen_->api(); }
  void attach(void* window) override { screen_->attach(window); }
  void detach() override { screen_->detach(); }
  bool has_window() const override { return screen_->has_window(); }
  Expected<bool> present(const std::function<void()>& draw, int w, int h) override {
    return screen_->present(draw, w, h);
  }
  Expected<void> begin_video(void* window) override {
    return window != nullptr ? Expected<void>() : fail("video", "", "no window");
  }
  Expected<void> video_frame(const std::function<void()>&, std::int64_t nanoseconds) override {
    times_.push_back(nanoseconds);
    return {};
  }

 private:
  std::unique_ptr<Screen> screen_;
  std::vector<std::int64_t>& times_;
};

TEST_P(SessionTest, MakesAVideoAndDrawsOn) {
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

TEST_P(SessionTest, AVideoCanBeStoppedAndLosesNothing) {
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

TEST_P(SessionTest, WalksWithAStickAndByKeys) {
  ASSERT_TRUE(load(file_with_start()));
  session_->stick(0, 1);
  EXPECT_LT(comes_to_rest_after([] {}), 300) << "nobody walks";
  session_->walk(true);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.motion == Motion::walk; }));
  EXPECT_LT(comes_to_rest_after([] {}), 300);
  const SavedView begin = *session_->saved_view();
  session_->stick(0, 1);
  for (int i = 0; i < 30; ++i) {
    EXPECT_TRUE(session_->frame(time_ += 1.0 / 60));
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_LT(comes_to_rest_after([&] { session_->stick(0, 0); }), 300);
  const SavedView there = *session_->saved_view();
  EXPECT_GT(glm::distance(camera::eye(there.view), camera::eye(begin.view)), 0.01);
  session_->handle({.kind = WindowEvent::Kind::key, .down = true, .key = 'S'}, time_);
  for (int i = 0; i < 30; ++i) {
    EXPECT_TRUE(session_->frame(time_ += 1.0 / 60));
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_LT(
      comes_to_rest_after([&] { session_->handle({.kind = WindowEvent::Kind::focus_lost}, 0); }),
      300);
  const SavedView back = *session_->saved_view();
  EXPECT_LT(glm::distance(camera::eye(back.view), camera::eye(begin.view)),
            glm::distance(camera::eye(there.view), camera::eye(begin.view)));
}

TEST_P(SessionTest, BenchmarksAndDrawsOn) {
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

TEST_P(SessionTest, ABenchmarkCanBeStopped) {
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

TEST_P(SessionTest, WithoutASceneThereIsNothingToMeasure) {
  session_->start_benchmark({});
  EXPECT_TRUE(run_until([this](const SessionState&) { return !session_->benchmark().running; }));
  EXPECT_THAT(session_->benchmark().error, HasSubstr("there is no scene"));
  EXPECT_FALSE(session_->image());
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

INSTANTIATE_TEST_SUITE_P(Gl, SessionTest, testing::ValuesIn(kImplementations),
                         [](const auto& which) { return std::string(host::name(which.param)); });

}  // namespace
}  // namespace fluxgs::viewer
