// What the camera learns from the cloud: size, up, and what lies under a pixel.
#include "camera/focus.h"
#include "camera/orbit.h"
#include "camera/scene_fit.h"
#include "camera/up_axis.h"
#include "support.h"
#include "support/scenes.h"

namespace fluxgs::camera::test {
namespace {

using fluxgs::test::one_splat;
using fluxgs::test::random_cloud;

void move_all(SplatCloud& cloud, const glm::vec3& way) {
  for (glm::vec3& p : cloud.positions) p += way;
}

TEST(Quantile, CountsWeights) {
  std::vector<Weighted> values = {{3, 1}, {1, 1}, {2, 2}};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.25), 1);
  EXPECT_EQ(quantile(values, 0.3), 2);
  EXPECT_EQ(quantile(values, 0.75), 2);
  EXPECT_EQ(quantile(values, 1), 3);
  for (Weighted& v : values) v.second = 0;
  EXPECT_EQ(quantile(values, 0.5), 2);
}

TEST(Bounds, FarFloatersAndThinHazeDoNotMatter) {
  SplatCloud cloud = random_cloud(4000, 0, 5);
  const SceneBounds clean = robust_bounds(cloud);
  EXPECT_LT(glm::length(clean.center), 0.05);
  EXPECT_NEAR(clean.radius, 1.2, 0.15);
  for (std::size_t i = 0; i < 20; ++i) cloud.positions[i] = {1e6f, -1e6f, 1e5f};
  for (std::size_t i = 100; i < 1500; ++i) {
    cloud.positions[i] *= 50.0f;
    cloud.opacity_logits[i] = -8;
  }
  const SceneBounds hazy = robust_bounds(cloud);
  EXPECT_LT(glm::length(hazy.center), 0.1);
  EXPECT_NEAR(hazy.radius, clean.radius, 0.1);
}

TEST(Bounds, FarFromTheOriginTheyAreAsLarge) {
  SplatCloud cloud = random_cloud(2000, 0, 5);
  const SceneBounds here = robust_bounds(cloud);
  move_all(cloud, {1e5f, -1e5f, 1e5f});
  const SceneBounds there = robust_bounds(cloud);
  EXPECT_NEAR(there.radius, here.radius, 0.02);
  EXPECT_LT(glm::distance(there.center - glm::dvec3(1e5, -1e5, 1e5), here.center), 0.02);
}

TEST(Bounds, EmptyCloudsSingleSplatsAndNaN) {
  EXPECT_EQ(robust_bounds(SplatCloud()).radius, 1);
  const SceneBounds one = robust_bounds(one_splat({5, 6, 7}, 0.1f, 2));
  EXPECT_EQ(one.center, glm::dvec3(5, 6, 7));
  EXPECT_NEAR(one.radius, 0.3, 1e-6);
  EXPECT_GT(robust_bounds(one_splat({5, 6, 7}, 1e-30f, -200)).radius, 0);
  SplatCloud broken = random_cloud(50, 0);
  for (glm::vec3& p : broken.positions) p.x = NAN;
  EXPECT_EQ(robust_bounds(broken).radius, 1);
}

TEST(Bounds, OfLargeCloudsASampleIsEnough) {
  const SplatCloud cloud = random_cloud(250'001, 0, 9);
  const SceneBounds bounds = robust_bounds(cloud);
  EXPECT_LT(glm::length(bounds.center), 0.02);
  EXPECT_NEAR(bounds.high.x, 0.96, 0.01);
}

TEST(Fit, TheWholeSphereIsSeenInAnyShapeOfWindow) {
  const SceneBounds bounds{.center = {1e5, 3, -2}, .radius = 2};
  for (const glm::dvec2 size : {glm::dvec2(640, 480), glm::dvec2(300, 900), glm::dvec2(50, 50)}) {
    for (const glm::dvec3 up : {kUp, glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0)}) {
      const ViewState view = fitting_view(bounds, up, 50 * kDegree);
      EXPECT_NEAR(roll(view, up), 0, 1e-9);
      EXPECT_NEAR(std::sin(elevation(view, up)), kInitialHeight, 1e-9);
      for (const glm::dvec3 way : {right(view), down(view), -right(view), -down(view)}) {
        const glm::dvec2 pixel = pixel_of(view, bounds.center + 2.0 * way, size);
        EXPECT_GT(std::min(pixel.x, pixel.y), 0);
        EXPECT_LT(std::max(pixel.x - size.x, pixel.y - size.y), 0);
      }
      EXPECT_LT(units_of(bounds).near_plane, view.distance - bounds.radius);
      EXPECT_GT(units_of(bounds).distances.farthest, view.distance);
    }
  }
  EXPECT_TRUE(is_finite(fitting_view(bounds, kUp, 1)));
}

/// Cameras on an arc around the origin that look at it from above.
std::vector<Camera> ring(const glm::dvec3& up, double degrees, double height) {
  std::vector<Camera> cameras;
  const glm::dvec3 front = level_front(up), side = glm::cross(up, front);
  for (int i = 0; i < 20; ++i) {
    const double angle = degrees * kDegree * i / 20;
    const glm::dvec3 at = 3.0 * (std::cos(angle) * front + std::sin(angle) * side) + height * up;
    cameras.push_back(camera_of(view_between(at, {0, 0, 0}, up, 1), 64, 48));
  }
  return cameras;
}

TEST(UpOfCameras, IsFoundAlsoWhereTheyLookDownFromOneSide) {
  const glm::dvec3 up = glm::normalize(glm::dvec3(0.3, 0.5, -0.8));
  for (const double degrees : {360.0, 90.0, 50.0}) {
    const UpAxis found = up_of_cameras(ring(up, degrees, 3));
    EXPECT_LT(glm::distance(found.direction, up), 1e-6) << degrees;
    EXPECT_NEAR(found.confidence, std::sqrt(0.5), 1e-6);
  }
}

TEST(UpOfCameras, ParallelViewsGiveTheirOwnUp) {
  const std::vector<Camera> same(5, camera_of(view_between({0, 0, -3}, {0, 0, 0}, kUp, 1), 9, 9));
  EXPECT_LT(glm::distance(up_of_cameras(same).direction, kUp), 1e-9);
  EXPECT_NEAR(up_of_cameras(same).confidence, 1, 1e-9);
  EXPECT_EQ(up_of_cameras({}).direction, kDefaultUp);
  EXPECT_EQ(up_of_cameras({}).confidence, 0);
}

/// A disc of ground with a few things standing on it, up being `up`.
SplatCloud ground_scene(const glm::dvec3& up, std::uint32_t seed = 4) {
  SplatCloud cloud = random_cloud(3000, 0, seed);
  const glm::dvec3 x = level_front(up), z = glm::cross(up, x);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = cloud.positions[i];
    const double height = i % 6 == 0 ? 0.3 * (p.y + 1) : 0.02 * p.y;
    const double spread = i % 6 == 0 ? 0.2 : 1;
    cloud.positions[i] = glm::vec3(spread * p.x * x + spread * p.z * z + height * up);
  }
  return cloud;
}

TEST(UpOfCloud, GroundIsFoundInAnyDirection) {
  for (const glm::dvec3 up : {glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 1, 0),
                              glm::normalize(glm::dvec3(0.4, -0.7, 0.4))}) {
    const UpAxis found = up_of_cloud(ground_scene(up));
    EXPECT_GT(glm::dot(found.direction, up), std::cos(5 * kDegree)) << up.x << up.y << up.z;
    EXPECT_GT(found.confidence, 0.3);
  }
}

TEST(UpOfCloud, WhereNothingIsToBeFoundUpIsTheUsual) {
  SplatCloud ball = random_cloud(3000, 0);
  SplatCloud pole = ball;
  for (glm::vec3& p : pole.positions) p.x *= 0.1f, p.z *= 0.1f;
  for (const SplatCloud& cloud : {SplatCloud(), one_splat({1, 1, 1}, 1, 0), ball, pole}) {
    EXPECT_EQ(up_of_cloud(cloud).direction, kDefaultUp);
    EXPECT_EQ(up_of_cloud(cloud).confidence, 0);
  }
}

TEST(UpOfCloud, FarFromTheOriginItIsTheSame) {
  SplatCloud cloud = ground_scene(kUp);
  const UpAxis here = up_of_cloud(cloud);
  move_all(cloud, {1e5f, 1e5f, -1e5f});
  EXPECT_GT(glm::dot(up_of_cloud(cloud).direction, here.direction), 0.999);
}

/// A big opaque wall at z = 6, and a low-opacity pane at z = 2 and an opaque ball at z = 4 before
/// its right half.
SplatCloud wall_ball_pane() {
  SplatCloud cloud;
  cloud.resize(3);
  cloud.positions = {{0, 0, 6}, {1, 0, 4}, {1, 0, 2}};
  cloud.log_scales = {{3, 3, -4}, glm::vec3(std::log(0.1f)), {-1, -1, -4}};
  cloud.opacity_logits = {8, 8, -2};
  return cloud;
}

TEST(Focus, FindsWhatIsSeenThere) {
  const SplatCloud cloud = wall_ball_pane();
  const ViewState view = view_between({0, 0, 0}, {0, 0, 1}, kUp, 60 * kDegree);
  const auto at = [&](const glm::dvec3& p) {
    return visible_point(cloud, view, pixel_of(view, p), kSize, 0.01);
  };
  ASSERT_TRUE(at({0, 0, 6}));
  EXPECT_LT(glm::distance(*at({0, 0, 6}), glm::dvec3(0, 0, 6)), 0.01);
  ASSERT_TRUE(at({1, 0, 4}));  // neither the wall behind nor the low-opacity pane before
  EXPECT_LT(glm::distance(*at({1, 0, 4}), glm::dvec3(1, 0, 4)), 0.1);
}

TEST(Focus, SeesNothingBehindTheEyeOrBesideTheScene) {
  const SplatCloud ball = one_splat({0, 0, 4}, 0.1f, 5);
  EXPECT_FALSE(visible_distance(ball, {{0, 0, 5}, {0, 0, 1}}, 0.001, 0.01));
  EXPECT_FALSE(visible_distance(ball, {{2, 0, 0}, {0, 0, 1}}, 0.001, 0.01));
  EXPECT_FALSE(visible_distance(SplatCloud(), {{0, 0, 0}, {0, 0, 1}}, 0.001, 0.01));
  SplatCloud broken = ball;
  broken.rotations[0] = {0, 0, 0, 0};
  EXPECT_NEAR(*visible_distance(broken, {{0, 0, 0}, {0, 0, 1}}, 0.001, 0.01), 4, 1e-6);
  broken.positions[0].x = NAN;
  EXPECT_FALSE(visible_distance(broken, {{0, 0, 0}, {0, 0, 1}}, 0.001, 0.01));
}

TEST(Focus, ThePointComesToTheCentreWithoutATurn) {
  const ViewState view = some_view();
  const glm::dvec3 point = view.target + glm::dvec3(0.5, 0.2, 1);
  const double depth = glm::dot(point - eye(view), forward(view));
  const ViewState focused = focused_on(view, point);
  EXPECT_EQ(focused.target, point);
  EXPECT_NEAR(focused.distance, 0.7 * depth, 1e-12);
  EXPECT_NEAR(turn_between(view, focused), 0, 1e-12);
  EXPECT_EQ(focused_on(view, point, {.nearest = 50, .farthest = 60}).distance, 50);
  EXPECT_TRUE(is_finite(focused_on(view, eye(view) - forward(view))));
}

}  // namespace
}  // namespace fluxgs::camera::test
