// What is under the pointer or the fingers stays under them.
#include "camera/pan_zoom.h"

#include "camera/fly.h"
#include "camera/orbit.h"
#include "support.h"

namespace fluxgs::camera::test {
namespace {

TEST(Pan, TheTargetsPlaneFollowsThePointer) {
  const ViewState view = some_view({1e5, 1e5, 1e5});
  const glm::dvec3 point = point_at(view, {100, 50}, view.distance, kSize);
  const ViewState moved = pan(view, {40, -25}, kSize);
  EXPECT_LT(glm::distance(pixel_of(moved, point), glm::dvec2(140, 25)), 1e-6);
  expect_same_view(pan(moved, {-40, 25}, kSize), view);
}

TEST(Zoom, ThePointUnderThePointerStays) {
  const ViewState view = some_view();
  for (const double factor : {0.3, 1.0, 1.15, 8.0}) {
    const glm::dvec2 pixel(77, 400);
    const glm::dvec3 point = point_at(view, pixel, view.distance, kSize);
    const ViewState zoomed = zoom(view, factor, pixel, kSize);
    EXPECT_LT(glm::distance(pixel_of(zoomed, point), pixel), 1e-9);
    EXPECT_NEAR(zoomed.distance, view.distance / factor, 1e-12);
    expect_same_view(zoom(zoomed, 1 / factor, pixel, kSize), view);
  }
}

TEST(Zoom, StopsAtTheLimitsAndIgnoresNonsense) {
  const DistanceLimits limits{.nearest = 1, .farthest = 20};
  EXPECT_DOUBLE_EQ(zoom(some_view(), 1e6, {0, 0}, kSize, limits).distance, 1);
  EXPECT_DOUBLE_EQ(zoom(some_view(), 1e-6, {0, 0}, kSize, limits).distance, 20);
  for (const double factor : {0.0, -1.0, double(NAN), double(INFINITY)})
    expect_same_view(zoom(some_view(), factor, {5, 5}, kSize, limits), some_view());
  ViewState outside = some_view();
  outside.distance = 30;
  EXPECT_DOUBLE_EQ(zoom(outside, 0.5, {0, 0}, kSize, limits).distance, 30);
  EXPECT_NEAR(zoom(outside, 1.01, {0, 0}, kSize, limits).distance, 20, 10);
}

TEST(Pinch, BothPointsStayUnderTheFingers) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x(0, 640), y(0, 480);
  const auto finger = [&] { return glm::dvec2(x(random), y(random)); };
  for (int i = 0; i < 200; ++i) {
    const TwoFingers before{finger(), finger()}, now{finger(), finger()};
    if (glm::distance(before.first, before.second) < 20) continue;
    const ViewState view = twist(some_view(), 0.1 * i, {9, 9}, kSize);
    const glm::dvec3 a = point_at(view, before.first, view.distance, kSize);
    const glm::dvec3 b = point_at(view, before.second, view.distance, kSize);
    const ViewState pinched = pinch(view, before, now, kSize);
    EXPECT_LT(glm::distance(pixel_of(pinched, a), now.first), 1e-6) << i;
    EXPECT_LT(glm::distance(pixel_of(pinched, b), now.second), 1e-6) << i;
    expect_same_view(pinch(pinched, now, before, kSize), view, 1e-7);
  }
}

TEST(Pinch, WithoutTwistItStaysLevelAndTheMiddleStays) {
  const ViewState view = some_view();
  const TwoFingers before{{100, 100}, {300, 200}}, now{{150, 260}, {420, 90}};
  const glm::dvec3 middle = point_at(view, {200, 150}, view.distance, kSize);
  const ViewState pinched = pinch(view, before, now, kSize, {}, Twist::ignored);
  EXPECT_NEAR(roll(pinched, kUp), 0, 1e-12);
  EXPECT_LT(glm::distance(pixel_of(pinched, middle), glm::dvec2(285, 175)), 1e-9);
  const DistanceLimits limits{.nearest = view.distance, .farthest = view.distance};
  EXPECT_LT(glm::distance(pixel_of(pinch(view, before, now, kSize, limits), middle),
                          glm::dvec2(285, 175)),
            1e-9);
}

TEST(Pinch, ClockwiseFingersTurnTheImageClockwise) {
  const ViewState view = some_view();
  const TwoFingers before{{220, 240}, {420, 240}}, now{{320, 140}, {320, 340}};
  const glm::dvec3 top = point_at(view, {320, 140}, view.distance, kSize);
  EXPECT_LT(glm::distance(pixel_of(pinch(view, before, now, kSize), top), glm::dvec2(420, 240)),
            1e-9);
}

TEST(Pinch, CoincidentFingersAndEmptyWindowsAreFinite) {
  const glm::dvec2 here(50, 60), there(90, 10);
  for (const glm::dvec2 size : {kSize, glm::dvec2(0, 0)})
    for (const TwoFingers& a : {TwoFingers{here, here}, TwoFingers{here, there}})
      for (const TwoFingers& b : {TwoFingers{there, there}, TwoFingers{there, here}})
        EXPECT_TRUE(is_finite(pinch(some_view(), a, b, size)));
  expect_same_view(pinch(some_view(), {here, here}, {there, there}, kSize),
                   pan(some_view(), there - here, kSize));
}

TEST(Fly, MovesTheEyeAndKeepsTheView) {
  const ViewState view = some_view();
  const ViewState ahead = fly(view, {.forward = 1}, 2, 0.5, kUp);
  EXPECT_LT(glm::distance(eye(ahead), eye(view) + forward(view)), 1e-12);
  EXPECT_NEAR(turn_between(ahead, view), 0, 1e-12);
  EXPECT_LT(glm::distance(eye(fly(view, {.up = 1}, 1, 3, kUp)), eye(view) + 3.0 * kUp), 1e-12);
  const ViewState slanted = fly(view, {.right = 1, .up = 1, .forward = -1}, 1, 1, kUp);
  EXPECT_NEAR(glm::distance(eye(slanted), eye(view)), 1, 1e-12);
  expect_same_view(fly(view, {}, 5, 1, kUp), view);
}

}  // namespace
}  // namespace fluxgs::camera::test
