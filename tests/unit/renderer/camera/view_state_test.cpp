// Views, and the cameras made of them.
#include "camera/view_state.h"

#include "support.h"

namespace fluxgs::camera::test {
namespace {

TEST(ViewState, LooksAtItsTargetWithUpUpwards) {
  const ViewState view = view_between({1, -2, -5}, {1, 0, 4}, kUp, 60 * kDegree);
  EXPECT_LT(glm::distance(eye(view), glm::dvec3(1, -2, -5)), 1e-12);
  EXPECT_LT(glm::distance(pixel_of(view, {1, 0, 4}), kSize / 2.0), 1e-9);
  EXPECT_LT(pixel_of(view, glm::dvec3(1, 0, 4) + kUp).y, 240);                  // up is up
  EXPECT_GT(pixel_of(view, glm::dvec3(1, 0, 4) + glm::dvec3(1, 0, 0)).x, 320);  // not mirrored
  EXPECT_NEAR(right(view).y, 0, 1e-12);
}

TEST(ViewState, FieldOfViewIsThatOfTheShorterSide) {
  const ViewState view = view_between({0, 0, 0}, {0, 0, 2}, kUp, 90 * kDegree);
  EXPECT_NEAR(pixel_of(view, {0, 2, 2}).y, 480, 1e-9);
  const Camera camera = camera_of(view, 640, 480);
  EXPECT_DOUBLE_EQ(camera.fx, camera.fy);
  const Camera upright = camera_of(view, 480, 640);
  EXPECT_DOUBLE_EQ(upright.fx, camera.fx);
  EXPECT_NEAR(view_of(upright, 2).fov, view.fov, 1e-12);
  EXPECT_NEAR(pixel_of(view, {2, 0, 2}, {480, 640}).x, 480, 1e-9);
}

TEST(ViewState, CamerasComeBack) {
  const ViewState view = some_view();
  expect_same_view(view_of(camera_of(view, 640, 480), view.distance), view, 1e-12);
  EXPECT_NEAR(view_of(camera_of(view, 640, 480), 1).fov, view.fov, 1e-12);
}

TEST(ViewState, PointsUnderPixelsProjectThere) {
  const ViewState view = some_view({1e5, -2e5, 3e5});
  for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(639, 12), glm::dvec2(320, 240)}) {
    EXPECT_LT(glm::distance(pixel_of(view, point_at(view, pixel, 7, kSize)), pixel), 1e-6);
    const Ray ray = ray_through(view, pixel, kSize);
    EXPECT_LT(glm::distance(pixel_of(view, ray.origin + 3.0 * ray.direction), pixel), 1e-6);
    EXPECT_NEAR(glm::length(ray.direction), 1, 1e-12);
  }
}

TEST(ViewState, DegenerateInputIsFinite) {
  EXPECT_TRUE(is_finite(view_between({1, 1, 1}, {1, 1, 1}, kUp, 1)));
  EXPECT_TRUE(is_finite(view_between({0, 0, 0}, {0, 5, 0}, kUp, 1)));  // along up
  EXPECT_TRUE(is_finite(view_between({0, 0, 0}, {0, 0, 5}, {0, 0, 0}, 1)));
  const Camera camera = camera_of(some_view(), 0, -3);
  EXPECT_EQ(camera.width, 1);
  EXPECT_EQ(camera.height, 1);
  EXPECT_TRUE(std::isfinite(point_at(some_view(), {0, 0}, 1, {0, 0}).x));
}

}  // namespace
}  // namespace fluxgs::camera::test
