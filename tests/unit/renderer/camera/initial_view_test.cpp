// The view that a scene is shown with first.
#include "camera/initial_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"

namespace fluxgs {
namespace {

/// Slope from the middle to the border of the image's shorter side.
double slope_in(const InitialView& initial, const glm::dvec2& size) {
  const SplatCloud cloud = test::random_cloud(50, 0, 1);
  return std::tan(0.5 * camera::initial_navigation(cloud, initial, size).view.fov);
}

InitialView taken_by(int width, int height) {
  InitialView view{.position = {0, 0, -4}, .fov_y = 2 * std::atan(0.5)};
  view.image_width = width;
  view.image_height = height;
  return view;
}

TEST(InitialViewCamera, ShowsAllOfThePhoto) {
  EXPECT_NEAR(slope_in(taken_by(400, 300), {800, 600}), 0.5, 1e-9);
  EXPECT_NEAR(slope_in(taken_by(400, 300), {1600, 900}), 0.5, 1e-9);
  EXPECT_NEAR(slope_in(taken_by(1600, 900), {800, 600}), 0.5 * 16 / 9 * 3 / 4, 1e-9);
  EXPECT_NEAR(slope_in(taken_by(300, 400), {800, 600}), 0.5 * 4 / 3, 1e-9);
  EXPECT_NEAR(slope_in(taken_by(400, 300), {600, 800}), 0.5 * 4 / 3, 1e-9);
}

TEST(InitialViewCamera, IsNoWiderThanAHundredDegrees) {
  const double longer = slope_in(taken_by(300, 600), {2000, 1000}) * 2;
  EXPECT_NEAR(std::atan(longer) * 2, 1.75, 1e-9);
  // But never narrower than the photo's shorter side
  EXPECT_NEAR(slope_in(taken_by(400, 300), {300, 1200}), 0.5, 1e-9);
  // Without the size of the photo as before
  EXPECT_NEAR(slope_in(taken_by(0, 0), {1600, 900}), 0.5, 1e-9);
}

}  // namespace
}  // namespace fluxgs
