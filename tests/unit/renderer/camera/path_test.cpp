// Camera paths: through views, round the target, and SuperSplat's.
#include "camera/path.h"

#include "camera/navigation.h"
#include "camera/orbit.h"
#include "support.h"

namespace fluxgs::camera::test {
namespace {

/// Views on the way through a house, some of them turned far from the one before.
std::vector<ViewState> some_views() {
  std::vector<ViewState> views;
  const glm::dvec3 eyes[] = {{0, 0, 0}, {3, -0.5, 1}, {3, -0.5, 6}, {-2, -1, 7}, {-4, 0, 2}};
  const glm::dvec3 targets[] = {{0, 0, 5}, {0, 0, 9}, {-9, 0, 6}, {-2, 1, 0}, {4, -1, 2}};
  for (int i = 0; i < 5; ++i)
    views.push_back(view_between(eyes[i], targets[i], kUp, (40 + 5 * i) * kDegree));
  return views;
}

double way_between(const ViewState& a, const ViewState& b) {
  return std::hypot(glm::distance(eye(a), eye(b)), a.distance * turn_between(a, b));
}

/// How near to a view the path comes.
double nearest(const CameraPath& path, const ViewState& view) {
  double least = INFINITY;
  for (int i = 0; i <= 5000; ++i)
    least = std::min(least, way_between(view_at(path, path.seconds * i / 5000, kSize), view));
  return least;
}

TEST(Path, GoesThroughItsViews) {
  const auto views = some_views();
  for (const bool closed : {false, true}) {
    const CameraPath path = path_through(views, closed, 12);
    for (const ViewState& view : views) EXPECT_LT(nearest(path, view), 0.02);
    expect_same_view(view_at(path, 0, kSize), views.front(), 1e-6);
    EXPECT_NEAR(view_at(path, 0, kSize).fov, views.front().fov, 1e-9);
  }
  const CameraPath open = path_through(views, false, 12);
  expect_same_view(view_at(open, 12, kSize), views.back(), 1e-6);
  expect_same_view(view_at(open, 99, kSize), views.back(), 1e-6);
  EXPECT_FALSE(is_over(open, 11.9));
  EXPECT_TRUE(is_over(open, 12));
}

TEST(Path, HasAConstantSpeed) {
  for (const bool closed : {false, true}) {
    const CameraPath path = path_through(some_views(), closed, 10);
    double least = INFINITY, most = 0;
    for (int frame = 0; frame < 600; ++frame) {
      const double step = way_between(view_at(path, frame / 60.0, kSize),
                                      view_at(path, (frame + 1) / 60.0 - 1e-9, kSize));
      least = std::min(least, step), most = std::max(most, step);
    }
    EXPECT_LT(most / least, 1.1);
  }
}

TEST(Path, ClosedOnesHaveNoBeginning) {
  const CameraPath path = path_through(some_views(), true, 10);
  const double e = 1e-4;
  const auto velocity = [&](double time) {
    return (eye(view_at(path, time + e, kSize)) - eye(view_at(path, time, kSize))) / e;
  };
  EXPECT_LT(glm::distance(velocity(10 - e), velocity(0)), 0.02 * glm::length(velocity(0)));
  expect_same_view(view_at(path, 13, kSize), view_at(path, 3, kSize));
  EXPECT_FALSE(is_over(path, 1e6));
}

TEST(Path, DoesNotJump) {
  auto views = some_views();
  for (ViewState& view : views)
    if (&view - views.data() == 2) view.orientation = -view.orientation;  // the same turn
  const CameraPath path = path_through(views, true, 10);
  for (int i = 0; i < 2000; ++i) {
    const ViewState a = view_at(path, i * 0.005, kSize), b = view_at(path, (i + 1) * 0.005, kSize);
    ASSERT_LT(turn_between(a, b), 0.03) << i;
    ASSERT_TRUE(is_finite(a));
  }
}

TEST(Path, TurnsOnTheSpotTakeTime) {
  ViewState left = some_view(), right = look(left, {200, 0}, kSize, kUp), away = right;
  away.target += glm::dvec3(5, 0, 0);
  const std::vector<ViewState> views{left, right, away};
  const CameraPath path = path_through(views, false, 2);
  EXPECT_GT(turn_between(view_at(path, 0, kSize), view_at(path, 0.3, kSize)), 0.05);
}

TEST(Path, OfOneViewOrEqualOnesStandsStill) {
  for (const std::size_t count : {1, 2, 5}) {
    const std::vector<ViewState> views(count, some_view());
    for (const bool closed : {false, true}) {
      const CameraPath path = path_through(views, closed, 3);
      for (const double time : {0.0, 1.0, 3.0, 7.5, -1.0, double(NAN)})
        expect_same_view(view_at(path, time, kSize), some_view(), 1e-6);
    }
  }
}

TEST(Path, AnOrbitKeepsDistanceElevationAndRoll) {
  ViewState begin = some_view();
  begin.orientation = glm::normalize(glm::angleAxis(0.2, forward(begin)) * begin.orientation);
  const CameraPath path = orbit_path(begin, kUp, 20);
  expect_same_view(view_at(path, 0, kSize), begin, 1e-6);
  for (int i = 0; i < 200; ++i) {
    const ViewState view = view_at(path, 0.1 * i, kSize);
    EXPECT_LT(glm::distance(view.target, begin.target), 1e-3);
    EXPECT_NEAR(glm::distance(eye(view), begin.target), begin.distance, 1e-3);
    EXPECT_NEAR(elevation(view, kUp), elevation(begin, kUp), 1e-3);
    EXPECT_NEAR(roll(view, kUp), roll(begin, kUp), 1e-3);
  }
  // Half of the time, half of the way round
  const glm::dvec3 opposite = level_direction(view_at(path, 10, kSize), kUp);
  EXPECT_NEAR(glm::dot(opposite, level_direction(begin, kUp)), -1, 1e-6);
}

CameraTrack track() {
  return {
      .keys = {{.seconds = 0, .position = {4, -1, 0}, .fov = 60 * kDegree},
               {.seconds = 1, .position = {0, -1, 4}, .fov = 60 * kDegree},
               {.seconds = 3, .position = {-4, -2, 0}, .target = {0, 1, 0}, .fov = 90 * kDegree}},
      .seconds = 4,
      .smoothness = 1,
      .end = CameraTrack::End::repeats};
}

TEST(Path, OfSuperSplatIsWhereItSaysAtItsTimes) {
  const CameraPath path = path_of(track());
  for (const CameraTrack::Key& key : track().keys) {
    const ViewState view = view_at(path, key.seconds, kSize);
    EXPECT_LT(glm::distance(eye(view), key.position), 1e-9);
    EXPECT_LT(glm::distance(view.target, key.target), 1e-9);
    EXPECT_NEAR(roll(view, kUp), 0, 1e-9) << "upright";
  }
  expect_same_view(view_at(path, 4.5, kSize), view_at(path, 0.5, kSize));
  EXPECT_LT(glm::distance(eye(view_at(path, 3.999, kSize)), track().keys[0].position), 0.05)
      << "the way back to the first key";
}

TEST(Path, OfSuperSplatIsASplineOfTheMeanSlopes) {
  // At the middle of keys 0 and 1: (p0 + p1) / 2 + (m0 − m1) / 8, the tangents by hand
  const glm::dvec3 p0(4, -1, 0), p1(0, -1, 4), p2(-4, -2, 0);
  const glm::dvec3 m0 = 0.5 * ((p0 - p2) + (p1 - p0)), m1 = 0.5 * ((p1 - p0) + 0.5 * (p2 - p1));
  const glm::dvec3 middle = 0.5 * (p0 + p1) + 0.125 * (m0 - m1);
  EXPECT_LT(glm::distance(eye(view_at(path_of(track()), 0.5, kSize)), middle), 1e-9);
  CameraTrack straight = track();
  straight.smoothness = 0;
  EXPECT_LT(glm::distance(eye(view_at(path_of(straight), 0.5, kSize)), 0.5 * (p0 + p1)), 1e-9);
}

TEST(Path, FieldsOfViewOfSuperSplatAreOfTheLongerSide) {
  const CameraPath path = path_of(track());
  const Camera wide = camera_of(view_at(path, 0, {1600, 900}), 1600, 900);
  EXPECT_NEAR(2 * std::atan(800 / wide.fx), 60 * kDegree, 1e-9);
  const Camera high = camera_of(view_at(path, 0, {900, 1600}), 900, 1600);
  EXPECT_NEAR(2 * std::atan(800 / high.fy), 60 * kDegree, 1e-9);
}

TEST(Path, ReturnsOrStopsAsItSays) {
  CameraTrack there_and_back = track();
  there_and_back.end = CameraTrack::End::returns;
  const CameraPath path = path_of(there_and_back);
  expect_same_view(view_at(path, 4.5, kSize), view_at(path, 3.5, kSize));
  expect_same_view(view_at(path, 8.5, kSize), view_at(path, 0.5, kSize));
  CameraTrack once = track();
  once.end = CameraTrack::End::stops;
  EXPECT_LT(glm::distance(eye(view_at(path_of(once), 9, kSize)), once.keys[2].position), 1e-9);
  once.keys.resize(1);
  for (const auto end : {CameraTrack::End::stops, CameraTrack::End::repeats}) {
    once.end = end;
    EXPECT_LT(glm::distance(eye(view_at(path_of(once), 2, kSize)), once.keys[0].position), 1e-9);
  }
}

TEST(Path, TracksThatEndAfterTheirDurationAreFinite) {
  CameraTrack odd = track();
  odd.seconds = 2;  // before the last key
  odd.keys[0].target = odd.keys[0].position;
  odd.keys[1].position = {0, -5, 0};  // along up
  for (const auto end :
       {CameraTrack::End::stops, CameraTrack::End::repeats, CameraTrack::End::returns}) {
    odd.end = end;
    for (int i = 0; i < 100; ++i)
      EXPECT_TRUE(is_finite(view_at(path_of(odd), 0.07 * i, kSize))) << i;
  }
}

TEST(Navigation, PlaysAPathFromItsBeginningUntilItIsOver) {
  Navigation n = navigation_from(some_view(), kUp, {});
  play(n, std::make_shared<const CameraPath>(path_through(some_views(), false, 3)), kSize);
  double seconds = 0;
  for (; seconds < 10 && advance(n, 1.0 / 60, kSize); seconds += 1.0 / 60) {
  }
  EXPECT_NEAR(seconds, 3 + 0.35, 0.1) << "the way to its beginning, and the path";
  expect_same_view(n.view, some_views().back(), 1e-6);
}

TEST(Navigation, ATouchEndsAPathAndClosedOnesGoOn) {
  Navigation n = navigation_from(some_view(), kUp, {});
  play(n, std::make_shared<const CameraPath>(path_through(some_views(), true, 1)), kSize);
  for (int i = 0; i < 300; ++i) EXPECT_TRUE(advance(n, 1.0 / 60, kSize));
  EXPECT_TRUE(n.playback);
  touch(n);
  EXPECT_FALSE(moving(n));
}

}  // namespace
}  // namespace fluxgs::camera::test
