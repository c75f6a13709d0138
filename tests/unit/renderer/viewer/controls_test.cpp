// Fingers, the gyroscope and the render scale, without a GPU.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "viewer/detail_control.h"
#include "viewer/frame_goal.h"
#include "viewer/gestures.h"
#include "viewer/gyroscope.h"

namespace fluxgs::viewer {
namespace {

using camera::Navigation;
using camera::ViewState;

const glm::dvec2 kSize(800, 600);
const glm::dvec3 kUp(0, -1, 0);

Navigation at_the_origin() {
  return camera::navigation_from(camera::view_between({0, -1, -4}, {0, 0, 0}, kUp, 0.9), kUp, {});
}

/// A hand over the screen.
struct Hand {
  Gestures gestures;
  Navigation n = at_the_origin();
  std::vector<Finger> down;
  double time = 10;

  std::optional<glm::dvec2> tell(TouchPhase phase, int id) {
    return apply({phase, id, down, time}, kSize, gestures, n);
  }
  void put(int id, glm::dvec2 at) {
    down.push_back({id, at});
    tell(TouchPhase::down, id);
  }
  void move(std::vector<glm::dvec2> to) {
    for (std::size_t i = 0; i < to.size(); ++i) down[i].position = to[i];
    tell(TouchPhase::moved, 0);
  }
  std::optional<glm::dvec2> lift(int id) {
    const auto result = tell(TouchPhase::up, id);
    std::erase_if(down, [&](const Finger& f) { return f.id == id; });
    return result;
  }
  std::optional<glm::dvec2> tap(glm::dvec2 at) {
    put(0, at);
    time += 0.05;
    const auto result = lift(0);
    time += 0.1;
    return result;
  }
};

bool same(const ViewState& a, const ViewState& b) {
  return a.target == b.target && a.orientation == b.orientation && a.distance == b.distance;
}

TEST(Gestures, OneFingerTurnsTheSceneAndAThrowGoesOn) {
  Hand hand;
  hand.put(0, {400, 300});
  for (int i = 1; i <= 10; ++i) {
    hand.time += 0.01;
    hand.move({{400 + 20.0 * i, 300}});
  }
  const ViewState dragged = camera::orbit(at_the_origin().view, {200, 0}, kSize, kUp);
  EXPECT_LT(glm::distance(camera::eye(hand.n.view), camera::eye(dragged)), 1e-9);
  hand.lift(0);
  EXPECT_TRUE(camera::moving(hand.n));
  hand.put(0, {10, 10});
  EXPECT_FALSE(camera::moving(hand.n)) << "a touch ends it";
}

TEST(Gestures, AFingerThatRestedThrowsNothing) {
  Hand hand;
  hand.put(0, {400, 300});
  hand.time += 0.02;
  hand.move({{500, 300}});
  hand.time += 1;
  hand.lift(0);
  EXPECT_FALSE(camera::moving(hand.n));
}

TEST(Gestures, TwoFingersMoveZoomAndRoll) {
  Hand pan;
  pan.put(0, {300, 300});
  pan.put(1, {500, 300});
  pan.move({{340, 330}, {540, 330}});
  EXPECT_LT(
      glm::distance(pan.n.view.target, camera::pan(at_the_origin().view, {40, 30}, kSize).target),
      1e-9);
  EXPECT_NEAR(pan.n.view.distance, at_the_origin().view.distance, 1e-9);

  Hand zoom;
  zoom.put(0, {350, 300});
  zoom.put(1, {450, 300});
  zoom.move({{300, 300}, {500, 300}});
  EXPECT_NEAR(zoom.n.view.distance, at_the_origin().view.distance / 2, 1e-9);

  Hand roll;
  roll.put(0, {300, 300});
  roll.put(1, {500, 300});
  roll.move({{400, 200}, {400, 400}});  // a quarter turn clockwise
  EXPECT_NEAR(std::abs(camera::roll(roll.n.view, kUp)), std::numbers::pi / 2, 1e-6);
}

TEST(Gestures, LiftingOneOfTwoFingersDoesNotJump) {
  Hand hand;
  hand.put(0, {300, 300});
  hand.put(1, {500, 300});
  hand.lift(0);
  const ViewState before = hand.n.view;
  hand.move({{500, 300}});
  EXPECT_TRUE(same(before, hand.n.view));
  hand.move({{560, 300}});
  EXPECT_LT(glm::distance(camera::eye(hand.n.view),
                          camera::eye(camera::orbit(before, {60, 0}, kSize, kUp))),
            1e-9);
}

TEST(Gestures, OnlyTheSecondTapLooksCloser) {
  Hand hand;
  EXPECT_FALSE(hand.tap({200, 200}));
  const auto pixel = hand.tap({210, 205});
  ASSERT_TRUE(pixel);
  EXPECT_EQ(*pixel, glm::dvec2(210, 205));
  EXPECT_FALSE(hand.tap({210, 205})) << "a third is a first again";
  hand.time += 1;
  EXPECT_FALSE(hand.tap({210, 205})) << "too late";
  EXPECT_FALSE(hand.tap({600, 500})) << "elsewhere";
  EXPECT_TRUE(same(hand.n.view, at_the_origin().view)) << "taps move nothing";
}

TEST(Gestures, ALongOrTremblingPressIsNoTap) {
  Hand hand;
  hand.tap({200, 200});
  hand.put(0, {200, 200});
  hand.time += 0.2;
  hand.move({{205, 203}});
  hand.time += 0.2;
  EXPECT_FALSE(hand.lift(0));
  EXPECT_TRUE(same(hand.n.view, at_the_origin().view)) << "within the slop nothing moves";
}

TEST(Gestures, AFingerIsAsLargeOnEveryScreen) {
  const auto moves = [](double density, double pixels) {
    Hand hand;
    hand.gestures.options.density = density;
    hand.put(0, {200, 200});
    hand.move({{200 + pixels, 200}});
    return !same(hand.n.view, at_the_origin().view);
  };
  EXPECT_TRUE(moves(1, 20));
  EXPECT_FALSE(moves(4, 20));
  EXPECT_TRUE(moves(4, 40));
}

TEST(Gestures, StrangeEventsAreHarmless) {
  Hand hand;
  hand.tell(TouchPhase::up, 7);
  hand.tell(TouchPhase::moved, 7);
  hand.down = {{3, {std::nan(""), 1}}};
  hand.tell(TouchPhase::down, 3);
  EXPECT_TRUE(hand.gestures.fingers.empty());
  hand.down.clear();
  hand.put(0, {1, 1});
  hand.put(0, {2, 2});
  EXPECT_EQ(hand.gestures.fingers.size(), 1U);
  hand.put(1, {2, 2});
  hand.put(2, {3, 3});
  hand.move({{std::numeric_limits<double>::infinity(), 0}, {1, 1}, {5, 5}});
  hand.tell(TouchPhase::cancelled, 0);
  EXPECT_TRUE(hand.gestures.fingers.empty());
  EXPECT_TRUE(std::isfinite(hand.n.view.distance));
}

/// A device whose back looks to the world's north (y), upright, turned by `heading` to the left and
/// `pitch` upwards.
DevicePose held(double heading, double pitch, double seconds, int screen_turns = 0) {
  // Upright: device y is the world's z
  const glm::dquat upright = glm::angleAxis(std::numbers::pi / 2, glm::dvec3(1, 0, 0));
  const glm::dquat turn = glm::angleAxis(heading, glm::dvec3(0, 0, 1));
  const glm::dquat tilt = glm::angleAxis(pitch, glm::dvec3(1, 0, 0));
  // The image is turned against the device
  const glm::dquat screen =
      glm::angleAxis(screen_turns * std::numbers::pi / 2, glm::dvec3(0, 0, 1));
  return {
      .rotation = turn * upright * tilt * screen, .screen_turns = screen_turns, .seconds = seconds};
}

glm::dvec3 forward_of(const Navigation& n) { return camera::forward(n.view); }

TEST(Gyroscope, TurnsTheViewAsTheDeviceTurns) {
  for (const int turns : {0, 1, 2, 3}) {
    Navigation n =
        camera::navigation_from(camera::view_between({0, 0, -4}, {0, 0, 0}, kUp, 0.9), kUp, {});
    const glm::dvec3 eye = camera::eye(n.view), right = camera::right(n.view);
    const glm::dvec3 forward = forward_of(n);
    Gyroscope gyroscope;
    follow(held(0.4, 0, 0, turns), gyroscope, n);
    EXPECT_LT(glm::distance(forward_of(n), forward), 1e-6) << "it begins where the view is";
    follow(held(0.4 - 0.3, 0.2, 5, turns), gyroscope, n);
    const glm::dvec3 wanted =
        std::cos(0.2) * (std::cos(0.3) * forward + std::sin(0.3) * right) + std::sin(0.2) * kUp;
    EXPECT_LT(glm::distance(forward_of(n), wanted), 1e-6) << turns << ": right and up";
    EXPECT_NEAR(camera::roll(n.view, kUp), 0, 1e-6);
    EXPECT_LT(glm::distance(camera::eye(n.view), eye), 1e-9) << "the eye stays";
  }
}

TEST(Gyroscope, GoesOverToTheDevicesPitchSmoothly) {
  Navigation n = at_the_origin();  // looks down a little
  const double before = camera::elevation(n.view, kUp);
  Gyroscope gyroscope;
  follow(held(0, 0, 0), gyroscope, n);
  EXPECT_NEAR(camera::elevation(n.view, kUp), before, 1e-9);
  follow(held(0, 0, 0.1), gyroscope, n);
  EXPECT_LT(camera::elevation(n.view, kUp), before);
  EXPECT_GT(camera::elevation(n.view, kUp), 0);
  follow(held(0, 0, 5), gyroscope, n);
  EXPECT_NEAR(camera::elevation(n.view, kUp), 0, 1e-6) << "level, as the device is";
}

TEST(Gyroscope, AnyPoseIsHarmless) {
  Navigation n = at_the_origin();
  Gyroscope gyroscope;
  const double nan = std::nan("");
  follow({.rotation = {0, 0, 0, 0}}, gyroscope, n);
  follow({.rotation = {nan, 0, 0, 1}}, gyroscope, n);
  EXPECT_TRUE(same(n.view, at_the_origin().view));
  for (int i = 0; i < 200; ++i) {  // flat on a table, over the head, upside down
    const glm::dquat q(std::sin(i * 1.1), std::cos(i * 0.7), std::sin(i * 0.3), std::cos(i * 1.9));
    follow({.rotation = q, .screen_turns = i % 4, .seconds = i * 0.01}, gyroscope, n);
    EXPECT_NEAR(glm::length(n.view.orientation), 1, 1e-9);
  }
}

TEST(DetailControl, HoldsTheDisplaysRate) {
  struct Work {
    double always, pixels, fits;  // seconds for a frame of full size; the scale
  };
  for (const auto& [always, pixels, fits] :
       {Work{0, 0.030, 0.7}, Work{0.002, 0.030, 0.6}, Work{0.008, 0.024, 0.6},
        Work{0.012, 0.020, 0.4}, Work{0.008, 0.041, 0.4}, Work{0.010, 0.039, 0.4}}) {
    DetailControl control(1.0 / 60);
    double scale = 1;
    for (int i = 0; i < 600; ++i) {
      const double work = always + pixels * scale * scale;
      scale = control.frame(std::ceil(work * 60) / 60).scale;  // the display waits for whole frames
    }
    EXPECT_EQ(scale, fits) << always;
  }
}

// Bound by the sort, by the projection, or by a display that is slower than it says.
TEST(DetailControl, FewerPixelsThatGainNothingAreTakenBack) {
  for (const double display : {1.0 / 60, 1.0 / 120}) {
    DetailControl control(display);
    int low = 0;
    constexpr int kFrames = 60 * 60;
    for (int i = 0; i < kFrames; ++i) {
      const double noise = 0.01 * std::sin(1.7 * i);
      low += control.frame(0.0245 * (1 + noise)) != Detail{};
    }
    EXPECT_EQ(control.detail(), Detail{}) << display;
    EXPECT_LT(low, kFrames / 10) << display;
  }
}

TEST(DetailControl, StopsWhereTheRestIsNotOfPixels) {
  // 12 ms at full size are for pixels, 25 for other things
  DetailControl control(1.0 / 60);
  double scale = 1;
  int lower = 0;
  for (int i = 0; i < 60 * 60; ++i) {
    scale = control.frame(0.025 + 0.012 * scale * scale).scale;
    lower += scale < 0.5;
  }
  EXPECT_LE(scale, 0.85);
  EXPECT_GE(scale, 0.5);
  EXPECT_LT(lower, 60 * 6);
}

// A scene of very many splats, whose frames take as long with any number of pixels.
TEST(DetailControl, LeavesOutSplatsWherePixelsDoNotDo) {
  const auto seconds = [](const Detail& detail) {
    return 0.004 + 0.040 / (1 + detail.min_weight) + 0.002 * detail.scale * detail.scale;
  };
  DetailControl control(1.0 / 60);
  Detail detail;
  for (int i = 0; i < 60 * 4; ++i) detail = control.frame(seconds(detail));
  EXPECT_EQ(detail, kDetails.back());
  EXPECT_LT(seconds(detail), kTooLong / 60);
  control.set_max(0.3);
  EXPECT_EQ(control.detail(), (Detail{0.3, 2}));
  std::vector<double> weights;  // up again, past steps that would change nothing
  for (int i = 0; i < 60 * 120; ++i)
    if (const double w = control.frame(1.0 / 90).min_weight; weights.empty() || w != weights.back())
      weights.push_back(w);
  EXPECT_EQ(weights, (std::vector<double>{2, 1, 0.5, 0}));
}

TEST(DetailControl, AImageThatWasGivenUpOnIsTriedAgain) {
  DetailControl control(1.0 / 60);
  const auto bound_by_the_sort = [&](int frames) {
    for (int i = 0; i < frames; ++i) control.frame(0.025);
    while (control.detail().scale < 1) control.frame(0.025);  // a trial is under way
  };
  bound_by_the_sort(400);
  double scale = 1;
  // Another view, of many pixels
  for (int i = 0; i < 60 * 20; ++i) scale = control.frame(0.030 * scale * scale).scale;
  EXPECT_EQ(scale, 0.7);
  // One that takes much longer needs not wait
  control = DetailControl(1.0 / 60);
  bound_by_the_sort(40 * 120);
  scale = 1;
  double seconds = 0;
  for (; scale == 1 && seconds < 10; seconds += 0.120) scale = control.frame(0.120).scale;
  EXPECT_LT(seconds, 3);
}

TEST(DetailControl, TriesMoreAndMoreSeldom) {
  DetailControl control(1.0 / 60);
  double scale = 1;
  int changes = 0;
  for (int i = 0; i < 60 * 120; ++i) {
    const double before = scale;
    scale = control.frame(std::ceil(0.030 * scale * scale * 60) / 60).scale;
    changes += scale != before;
  }
  EXPECT_LE(changes, 14) << "in two minutes";
}

TEST(DetailControl, GoesUpAgainWhenThereIsRoom) {
  DetailControl control(1.0 / 60);
  double scale = 1;
  for (int i = 0; i < 300; ++i) scale = control.frame(0.15 * scale * scale).scale;
  EXPECT_EQ(control.detail().scale, 0.4);
  for (int i = 0; i < 60 * 120; ++i) control.frame(1.0 / 60);
  EXPECT_EQ(control.detail().scale, 1);
}

TEST(DetailControl, PausesAndNonsenseAreNoFrames) {
  DetailControl control(1.0 / 60);
  for (int i = 0; i < 100; ++i) control.frame(3.0);
  for (int i = 0; i < 100; ++i) control.frame(std::nan(""));
  for (int i = 0; i < 100; ++i) {
    control.frame(0.05);
    if (i % 5 == 0) control.pause();
  }
  EXPECT_EQ(control.detail().scale, 1);
  control.set_frame_seconds(-1);
  for (int i = 0; i < 300; ++i) control.frame(1.0 / 60);
  EXPECT_EQ(control.detail().scale, 1);
}

TEST(DetailControl, HeatLowersItBeforeTheSystemDoes) {
  EXPECT_EQ(coolest_scale({}), 1);
  EXPECT_EQ(coolest_scale({.headroom = std::nan("")}), 1);
  EXPECT_LT(coolest_scale({.headroom = 0.9}), 1) << "severe throttling begins at 1";
  EXPECT_LT(coolest_scale({.status = 2}), coolest_scale({.status = 1}));
  EXPECT_EQ(coolest_scale({.status = 4}), 0.5);
  DetailControl control(1.0 / 60);
  control.set_max(0.7);
  for (int i = 0; i < 100; ++i) control.frame(1.0 / 60);
  EXPECT_EQ(control.detail().scale, 0.7);
  for (int i = 0; i < 12; ++i) control.frame(0.05);
  EXPECT_EQ(control.detail(), (Detail{0.7, 0.5})) << "a step down is one that can be seen";
}

/// Draws for so many seconds frames that take `work` at scale 1, on a display that waits for whole
/// frames of 1/120 s. Returns the mean rate of the last second.
double play(FrameGoal& goal, double seconds, double work, double display = 1.0 / 120) {
  double last_second = 0;
  int frames = 0;
  for (double t = 0; t < seconds;) {
    const double needed =
        std::max(work * goal.detail().scale * goal.detail().scale, goal.seconds());
    const double frame = std::ceil(needed / display - 1e-9) * display;
    goal.frame(frame);
    t += frame;
    if (t > seconds - 1) last_second += frame, ++frames;
  }
  return frames / last_second;
}

TEST(FrameGoal, ASlowDisplayIsHeld) {
  FrameGoal goal;
  EXPECT_NEAR(play(goal, 10, 0.030, 1.0 / 60), 60, 1);
  EXPECT_EQ(goal.detail().scale, 0.7);
  goal.set_display(1.0 / 30);
  EXPECT_EQ(goal.seconds(), 1.0 / 30);
}

TEST(FrameGoal, AFastDisplayIsUsedWhereNearlyAllPixelsAreThere) {
  for (const auto& [work, rate, scale] :
       {std::tuple(0.005, 120, 1.0), std::tuple(0.011, 120, 0.85), std::tuple(0.014, 60, 1.0),
        std::tuple(0.020, 60, 0.85)}) {
    FrameGoal goal;
    goal.set_display(1.0 / 120);
    EXPECT_NEAR(play(goal, 30, work), rate, 0.02 * rate) << work;
    EXPECT_EQ(goal.detail().scale, scale) << work;
  }
}

TEST(FrameGoal, TheFasterRateIsTriedMoreAndMoreSeldom) {
  FrameGoal goal;
  goal.set_display(1.0 / 120);
  int changes = 0;
  for (int i = 0; i < 240; ++i) {
    const double before = goal.seconds();
    play(goal, 0.5, 0.014);
    changes += goal.seconds() != before;
  }
  EXPECT_GE(changes, 2);
  EXPECT_LE(changes, 14) << "in two minutes";
}

// Bound by the sort: fewer pixels gain nothing, and neither does the faster rate.
TEST(FrameGoal, FramesThatComeLateAllTheSameGiveItUp) {
  FrameGoal goal;
  goal.set_display(1.0 / 120);
  for (int i = 0; i < 400; ++i) goal.frame(1.0 / 60);
  for (int i = 0; i < 200; ++i) goal.frame(1.0 / 70);
  EXPECT_EQ(goal.seconds(), 1.0 / 60);
  EXPECT_EQ(goal.detail().scale, 1);
}

TEST(FrameGoal, HeatTakesTheRateFirst) {
  FrameGoal goal;
  goal.set_display(1.0 / 120);
  EXPECT_NEAR(play(goal, 10, 0.005), 120, 1);
  goal.set_heat({.status = 1});
  EXPECT_EQ(goal.seconds(), 1.0 / 60);
  EXPECT_EQ(goal.detail().scale, 1);
  EXPECT_NEAR(play(goal, 10, 0.005), 60, 1) << "it is not tried while it is warm";
  goal.set_heat({.status = 2});
  EXPECT_EQ(goal.detail().scale, 0.7);
  EXPECT_EQ(goal.coolest(), 0.7);
  goal.set_heat({});
  EXPECT_NEAR(play(goal, 20, 0.005), 120, 1);
  EXPECT_EQ(goal.coolest(), 1);
}

TEST(FrameGoal, FewerPixelsMayBeWantedWhileSomethingMoves) {
  FrameGoal goal;
  goal.set_most(0.5);
  play(goal, 10, 0.002, 1.0 / 60);
  EXPECT_EQ(goal.detail().scale, 0.5);
  EXPECT_EQ(goal.coolest(), 1) << "a view at rest has all of them";
  goal.set_heat({.status = 3});
  EXPECT_LE(goal.detail().scale, 0.5);
  goal.set_heat({});
  goal.set_most(1);
  EXPECT_EQ(goal.detail().scale, 1);
}

TEST(FrameGoal, NonsenseIsNoFrame) {
  FrameGoal goal;
  goal.set_display(std::nan(""));
  goal.set_display(-1);
  EXPECT_EQ(goal.seconds(), 1.0 / 60);
  goal.set_display(1.0 / 120);
  for (const double odd : {std::nan(""), -1.0, 0.0, 100.0}) goal.frame(odd);
  EXPECT_EQ(goal.seconds(), 1.0 / 60);
}

}  // namespace
}  // namespace fluxgs::viewer
