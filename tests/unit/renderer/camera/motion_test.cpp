// What goes on by itself: glides, transitions, and all of it together.
#include "camera/inertia.h"
#include "camera/navigation.h"
#include "camera/transition.h"
#include "support.h"

namespace fluxgs::camera::test {
namespace {

TEST(Glide, TakesTheSamePathAtAnyFrameRate) {
  const auto at_rate = [](double hertz) {
    Glide glide = thrown({900, -400});
    glm::dvec2 way(0), at_half_second(0);
    for (int frame = 0; moving(glide) && frame < 10'000; ++frame) {
      if (frame == std::lround(0.5 * hertz)) at_half_second = way;
      way += advance(glide, 1 / hertz);
    }
    EXPECT_FALSE(moving(glide));
    return std::pair(at_half_second, way);
  };
  const auto [half, end] = at_rate(60);
  EXPECT_NEAR(glm::length(end), 0.22 * (std::hypot(900, 400) - 4), 1e-9);
  for (const double hertz : {30.0, 120.0, 144.0, 1000.0}) {
    const auto [other_half, other_end] = at_rate(hertz);
    EXPECT_LT(glm::distance(other_half, half), 1e-9) << hertz;
    EXPECT_LT(glm::distance(other_end, end), 1e-9) << hertz;
  }
}

TEST(Glide, EndsAndNeedsAThrow) {
  Glide glide = thrown({1e300, 0});
  EXPECT_NEAR(glm::length(glide.velocity), 20'000, 1e-6);
  EXPECT_TRUE(std::isfinite(advance(glide, 1e9).x));
  EXPECT_FALSE(moving(glide));
  EXPECT_FALSE(moving(thrown({0, 0})));
  EXPECT_FALSE(moving(thrown({3, 0})));
  EXPECT_FALSE(moving(thrown({NAN, 0})));
  Glide rest;
  EXPECT_EQ(advance(rest, 1), glm::dvec2(0.0));
  Glide going = thrown({100, 0});
  EXPECT_EQ(advance(going, 0), glm::dvec2(0.0));
  EXPECT_EQ(advance(going, -1), glm::dvec2(0.0));
}

TEST(PointerTrail, KnowsThrowsFromRests) {
  PointerTrail trail;
  EXPECT_EQ(velocity(trail, 0), glm::dvec2(0.0));
  for (int i = 0; i < 100; ++i) add(trail, 0.01 * i, {3.0 * i, -1.0 * i});
  EXPECT_NEAR(velocity(trail, 0.99).x, 300, 1e-9);
  EXPECT_NEAR(velocity(trail, 0.99).y, -100, 1e-9);
  EXPECT_EQ(velocity(trail, 1.2), glm::dvec2(0.0));
  PointerTrail same_time;
  add(same_time, 5, {0, 0});
  add(same_time, 5, {10, 0});
  EXPECT_TRUE(std::isfinite(velocity(same_time, 5).x));
}

TEST(Transition, StartsAndEndsAtRestAndArrivesExactly) {
  ViewState to = some_view({7, 8, 9});
  to.distance = 40;
  to.orientation = glm::angleAxis(2.0, glm::normalize(glm::dvec3(1, 2, 3))) * to.orientation;
  Transition transition{.from = some_view(), .to = to};
  expect_same_view(between(transition.from, to, 0), transition.from, 1e-12);
  EXPECT_LT(glm::distance(between(some_view(), to, 0.01).target, some_view().target), 1e-3);
  double last = 0;
  for (int i = 0; i < 21; ++i) {
    const ViewState view = advance(transition, 1.0 / 60);
    EXPECT_TRUE(is_finite(view));
    EXPECT_GE(view.distance, last);
    last = view.distance;
  }
  EXPECT_TRUE(finished(transition));
  const ViewState end = advance(transition, 0);
  EXPECT_EQ(end.target, to.target);
  EXPECT_EQ(end.distance, to.distance);
  Transition at_once{.from = some_view(), .to = to, .seconds = 0};
  EXPECT_EQ(advance(at_once, 0).distance, to.distance);
}

TEST(Transition, TurnsTheShorterWayRound) {
  ViewState to = some_view();
  to.orientation = -to.orientation;  // the same turn
  expect_same_view(between(some_view(), to, 0.5), some_view());
}

Navigation navigation() { return navigation_from(some_view(), kUp, {}); }

TEST(Navigation, AThrowGoesOnUntilItIsTouched) {
  Navigation n = navigation();
  EXPECT_FALSE(advance(n, 1, kSize));
  release(n, DragAction::orbit, {500, 0});
  EXPECT_TRUE(advance(n, 0.1, kSize));
  EXPECT_GT(turn_between(n.view, some_view()), 0.05);
  touch(n);
  const ViewState held = n.view;
  EXPECT_FALSE(advance(n, 0.1, kSize));
  expect_same_view(n.view, held);
}

TEST(Navigation, ThrownOrbitsEndAtTheSameViewAtAnyFrameRate) {
  const auto end_at = [](double hertz) {
    Navigation n = navigation();
    release(n, DragAction::orbit, {700, -150});
    while (advance(n, 1 / hertz, kSize)) {
    }
    return n.view;
  };
  const ViewState at_60 = end_at(60);
  expect_same_view(end_at(30), at_60);
  expect_same_view(end_at(120), at_60);
}

TEST(Navigation, FliesWhileAKeyIsHeld) {
  Navigation n = navigation();
  n.flying.forward = 1;
  n.speed_factor = 4;
  EXPECT_TRUE(advance(n, 0.25, kSize));
  EXPECT_NEAR(glm::distance(eye(n.view), eye(some_view())), 0.5, 1e-12);
  n.flying = {};
  EXPECT_FALSE(moving(n));
}

TEST(Navigation, ResetGoesHome) {
  Navigation n = navigation();
  drag(n, DragAction::pan, {100, 50}, kSize);
  drag(n, DragAction::look, {10, 50}, kSize);
  reset(n);
  for (int i = 0; i < 60 && advance(n, 1.0 / 60, kSize); ++i) {
  }
  expect_same_view(n.view, some_view());
}

TEST(Navigation, FlippingUpTurnsTheImageAndTwiceIsNothing) {
  Navigation n = navigation();
  const glm::dvec3 above = n.view.target + 0.3 * kUp;
  EXPECT_LT(pixel_of(n.view, above).y, 240);
  flip_up(n);
  EXPECT_LT(glm::distance(n.up, -kUp), 1e-15);
  EXPECT_GT(pixel_of(n.view, above).y, 240);
  EXPECT_NEAR(roll(n.view, n.up), 0, 1e-9);
  EXPECT_NEAR(elevation(n.view, n.up), elevation(some_view(), kUp), 1e-9);
  flip_up(n);
  expect_same_view(n.view, some_view());
  expect_same_view(n.home, some_view());
}

}  // namespace
}  // namespace fluxgs::camera::test
