// Fingers, sensors, sticks and paths that move the view of a viewer on its own thread.
#include "unit/renderer/viewer/session_fixture.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "camera/orbit.h"

namespace fluxgs::viewer {
namespace {

using namespace std::chrono_literals;
using namespace session_test;

using SessionMotionTest = SessionTest;

// Whoever sorts, a drag is movement: it has a rate, and a scale that holds the display's.
TEST_P(SessionMotionTest, AFingerThatDragsIsMeasured) {
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

TEST_P(SessionMotionTest, AFingerTurnsItAndResetLeadsBack) {
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

TEST_P(SessionMotionTest, AViewThatWasLeftIsComeBackTo) {
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

TEST_P(SessionMotionTest, FlippingTurnsItUpsideDown) {
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

TEST_P(SessionMotionTest, TheGyroscopeLooksAround) {
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

TEST_P(SessionMotionTest, WhatBeginsToMoveIsDrawnHoweverLateTheDisplayAsks) {
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

TEST_P(SessionMotionTest, DriftsUntilItIsTouched) {
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

TEST_P(SessionMotionTest, PlaysAPathUntilItIsTouched) {
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

TEST_P(SessionMotionTest, GoesToASavedViewButNotToOneThatIsNone) {
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

TEST_P(SessionMotionTest, WalksWithAStickAndByKeys) {
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

FLUXGS_GL_TEST_SUITE(SessionMotionTest);

}  // namespace
}  // namespace fluxgs::viewer
