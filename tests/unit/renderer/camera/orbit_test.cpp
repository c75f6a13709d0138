// Turning around the target and around the eye.
#include "camera/orbit.h"

#include "camera/pan_zoom.h"
#include "support.h"

namespace fluxgs::camera::test {
namespace {

TEST(Orbit, TheNearSideFollowsThePointer) {
  const ViewState view = some_view();
  const glm::dvec3 near = view.target - 0.5 * forward(view);
  const glm::dvec2 before = pixel_of(view, near);
  EXPECT_GT(pixel_of(orbit(view, {30, 0}, kSize, kUp), near).x, before.x + 1);
  EXPECT_GT(pixel_of(orbit(view, {0, 30}, kSize, kUp), near).y, before.y + 1);
  EXPECT_GT(elevation(orbit(view, {0, 30}, kSize, kUp), kUp), elevation(view, kUp));
}

TEST(Orbit, KeepsTargetDistanceAndLevel) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> pixels(-80, 80);
  ViewState view = some_view({1e5, 0, -1e5});
  for (int i = 0; i < 10'000; ++i) {
    view = orbit(view, {pixels(random), pixels(random)}, kSize, kUp);
    ASSERT_NEAR(roll(view, kUp), 0, 1e-9) << i;
    ASSERT_LT(glm::dot(down(view), kUp), 0) << i;  // never head over heels
    ASSERT_TRUE(is_finite(view));
  }
  EXPECT_LT(glm::distance(view.target, glm::dvec3(1e5, 0, -1e5)), 1e-12);
  EXPECT_NEAR(glm::distance(eye(view), view.target), some_view().distance, 1e-9);
}

TEST(Orbit, ThereAndBack) {
  ViewState rolled = twist(some_view(), 0.7, {100, 50}, kSize);
  for (const ViewState& start : {some_view(), rolled}) {
    ViewState view = start;
    const glm::dvec2 drags[] = {{31, 7}, {-80, 20}, {12, -50}};
    for (const glm::dvec2& d : drags) view = orbit(view, d, kSize, kUp);
    EXPECT_GT(turn_between(view, start), 0.1);
    for (const glm::dvec2& d : drags) view = orbit(view, -d, kSize, kUp);
    expect_same_view(view, start);
  }
}

TEST(Orbit, AFullTurnReturnsAndAShorterSideIsHalfOfIt) {
  const ViewState start = some_view();
  ViewState view = start;
  for (int i = 0; i < 960; ++i) view = orbit(view, {1, 0}, kSize, kUp);
  expect_same_view(view, start);
  const ViewState half = orbit(start, {480, 0}, kSize, kUp);
  EXPECT_NEAR(glm::dot(level_direction(half, kUp), level_direction(start, kUp)), -1, 1e-12);
}

TEST(Orbit, DoesNotFlipOverThePole) {
  const glm::dvec3 before = right(some_view());
  for (const double way : {1e4, -1e4, 1e9}) {
    const ViewState view = orbit(some_view(), {0, way}, kSize, kUp);
    EXPECT_NEAR(std::abs(elevation(view, kUp)), 89.5 * kDegree, 1e-9);
    EXPECT_LT(glm::distance(right(view), before), 1e-9);
  }
  const TurnLimits above{.lowest = 5 * kDegree, .highest = 60 * kDegree};
  EXPECT_NEAR(elevation(orbit(some_view(), {0, -1e4}, kSize, kUp, above), kUp), 5 * kDegree, 1e-9);
  EXPECT_NEAR(elevation(orbit(some_view(), {0, 1e4}, kSize, kUp, above), kUp), 60 * kDegree, 1e-9);
}

TEST(Orbit, FromOutsideTheLimitsItTurnsBackInWithoutAJump) {
  const ViewState below = view_between({0, 3, -3}, {0, 0, 0}, kUp, 1);  // y is down
  const TurnLimits above{.lowest = 0, .highest = 1};
  expect_same_view(orbit(below, {0, -10}, kSize, kUp, above), below);
  const ViewState back = orbit(below, {0, 10}, kSize, kUp, above);
  EXPECT_NEAR(elevation(back, kUp) - elevation(below, kUp), 10 * std::numbers::pi / 480, 1e-9);
}

TEST(Orbit, StartsFromThePoleItself) {
  for (const double side : {1.0, -1.0}) {
    const ViewState pole = view_between(side * 3.0 * kUp, {0, 0, 0}, kUp, 1);
    ASSERT_NEAR(elevation(pole, kUp), side * 90 * kDegree, 1e-6);
    expect_same_view(orbit(pole, {0, 0}, kSize, kUp), pole, 1e-7);
    const ViewState away = orbit(pole, {0, -side * 100}, kSize, kUp);
    EXPECT_NEAR(std::abs(elevation(away, kUp)), (90 - 37.5) * kDegree, 1e-6);
    EXPECT_NEAR(roll(away, kUp), 0, 1e-6);
  }
}

TEST(Orbit, ARolledImageTurnsAsItLooks) {
  const ViewState rolled = twist(some_view(), 90 * kDegree, kSize / 2.0, kSize);
  const double before = roll(rolled, kUp);
  EXPECT_NEAR(std::abs(before), 90 * kDegree, 1e-9);
  const glm::dvec3 near = rolled.target - 0.5 * forward(rolled);
  EXPECT_GT(pixel_of(orbit(rolled, {30, 0}, kSize, kUp), near).x, 321);
  EXPECT_GT(pixel_of(orbit(rolled, {0, 30}, kSize, kUp), near).y, 241);
  EXPECT_NEAR(roll(orbit(rolled, {30, 40}, kSize, kUp), kUp), before, 1e-9);
  EXPECT_NEAR(roll(upright(rolled, kUp), kUp), 0, 1e-12);
  expect_same_view(upright(rolled, kUp), some_view());
}

TEST(Look, TurnsAboutTheEyeAndTheSceneFollows) {
  const ViewState view = some_view();
  const ViewState turned = look(view, {3, 2}, kSize, kUp);
  EXPECT_LT(glm::distance(eye(turned), eye(view)), 1e-12);
  const glm::dvec2 moved = pixel_of(turned, view.target) - kSize / 2.0;
  EXPECT_NEAR(moved.x, 3, 0.5);
  EXPECT_NEAR(moved.y, 2, 0.1);
  EXPECT_NEAR(roll(turned, kUp), 0, 1e-9);
  expect_same_view(look(turned, {-3, -2}, kSize, kUp), view);
}

TEST(Orbit, NothingMovesWithoutADragAndZeroSizesAreFinite) {
  for (const glm::dvec2 size : {kSize, glm::dvec2(0, 0)}) {
    expect_same_view(orbit(some_view(), {0, 0}, size, kUp), some_view());
    expect_same_view(look(some_view(), {0, 0}, size, kUp), some_view());
    EXPECT_TRUE(is_finite(orbit(some_view(), {1, 1}, size, kUp)));
    EXPECT_TRUE(is_finite(look(some_view(), {1, 1}, size, kUp)));
  }
}

}  // namespace
}  // namespace fluxgs::camera::test
