// Auto-orbit: a slow turn that goes on by itself.
#include "camera/drift.h"

#include "camera/navigation.h"
#include "camera/orbit.h"
#include "support.h"

namespace fluxgs::camera::test {
namespace {

/// About the middle of a scene of radius 2.
Navigation about_the_middle() {
  SceneUnits units;
  units.center = {1, 2, 3};
  units.radius = 2;
  return navigation_from(some_view(), kUp, units);
}

/// Inside of a room, with a wall in the middle of the image.
Navigation in_a_room() {
  Navigation n = about_the_middle();
  n.units.radius = 11;
  n.units.center = n.view.target + glm::dvec3(0, 0, 6);
  return n;
}

/// The angle about up from one view to another, positive as drifts turn.
double heading_between(const ViewState& from, const ViewState& to) {
  const glm::dvec3 a = level_direction(from, kUp), b = level_direction(to, kUp);
  return std::atan2(glm::dot(glm::cross(a, b), kUp), glm::dot(a, b));
}

void let_pass(Navigation& n, double seconds, double hertz = 60) {
  for (int i = 0; i < std::lround(seconds * hertz); ++i)
    EXPECT_TRUE(advance(n, 1 / hertz, kSize)) << "it goes on";
}

TEST(Drift, TakesUpFromWhereTheViewIsAndEasesIn) {
  Navigation n = about_the_middle();
  drift(n);
  expect_same_view(n.view, some_view());
  let_pass(n, 0.1);
  EXPECT_LT(heading_between(some_view(), n.view), 0.1 * 0.1 * kDriftSpeed) << "not at once";
  const ViewState early = n.view;
  let_pass(n, 1);
  const double first = heading_between(early, n.view);
  let_pass(n, 2);
  const ViewState later = n.view;
  let_pass(n, 1);
  EXPECT_GT(first, 0);
  EXPECT_LT(first, heading_between(later, n.view));
  EXPECT_NEAR(heading_between(later, n.view), kDriftSpeed, 1e-9) << "at full speed";
}

TEST(Drift, LeavesDistanceElevationAndRollAsTheyAre) {
  Navigation n = about_the_middle();
  n.view = orbit(n.view, {0, -60}, kSize, kUp);
  n.view.orientation = glm::normalize(glm::angleAxis(0.2, forward(n.view)) * n.view.orientation);
  const ViewState begin = n.view;
  drift(n);
  let_pass(n, 90);
  EXPECT_GT(heading_between(begin, n.view), 1) << "round and on";
  EXPECT_EQ(n.view.distance, begin.distance);
  EXPECT_EQ(n.view.target, begin.target);
  EXPECT_NEAR(elevation(n.view, kUp), elevation(begin, kUp), 1e-9);
  EXPECT_NEAR(roll(n.view, kUp), roll(begin, kUp), 1e-9);
}

TEST(Drift, SwingsToAndFroWhereTheWayRoundMayLeadThroughWalls) {
  Navigation n = in_a_room();
  const ViewState begin = n.view;
  drift(n);
  double least = 0, most = 0;
  for (int i = 0; i < 60 * 60; ++i) {
    advance(n, 1.0 / 60, kSize);
    const double heading = heading_between(begin, n.view);
    least = std::min(least, heading), most = std::max(most, heading);
  }
  EXPECT_NEAR(most, 0.35, 1e-3);
  EXPECT_NEAR(least, -0.35, 1e-3);
}

TEST(Drift, IsTheSameAtAnyFrameRate) {
  const auto after_a_while = [](Navigation n, double hertz) {
    drift(n);
    let_pass(n, 7, hertz);
    return n.view;
  };
  for (const Navigation& n : {about_the_middle(), in_a_room()})
    for (const double hertz : {24.0, 30.0, 120.0})
      expect_same_view(after_a_while(n, hertz), after_a_while(n, 60));
}

TEST(Drift, EndsWithATouchAndBeginsAgain) {
  Navigation n = about_the_middle();
  drift(n);
  let_pass(n, 3);
  touch(n);
  const ViewState held = n.view;
  EXPECT_FALSE(moving(n));
  EXPECT_FALSE(advance(n, 1, kSize));
  expect_same_view(n.view, held);
  drift(n);
  let_pass(n, 3);
  EXPECT_GT(heading_between(held, n.view), 0.1);
}

TEST(Drift, EndsWithEverythingThatMovesTheView) {
  for (void (*other)(Navigation&) : {&reset, &flip_up, &touch}) {
    Navigation n = about_the_middle();
    drift(n);
    other(n);
    EXPECT_FALSE(n.drift);
  }
}

}  // namespace
}  // namespace fluxgs::camera::test
