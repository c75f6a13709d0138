// Smaller images for the coarse start.
#include "trainer/data/pyramid.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace fluxgs {
namespace {

View gradient_view(int width, int height) {
  View view{test::camera_in_front(width, height), Image<std::uint8_t>(width, height, 3), "a"};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        view.rgb.at(x, y)[c] = static_cast<std::uint8_t>(2 * x + 3 * y + c);
  return view;
}

TEST(Pyramid, AHalvedViewShowsTheMeansAndItsCameraSeesTheSame) {
  const View view = gradient_view(41, 30), half = halved(view);
  ASSERT_EQ(half.camera.width, 20);
  ASSERT_EQ(half.camera.height, 15);
  for (int y = 0; y < 15; ++y)
    for (int x = 0; x < 20; ++x)
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(half.rgb.at(x, y)[c], (4 * (4 * x + 6 * y + c) + 2 * 5 + 2) / 4);
  // A point lands on the same place of the image
  const glm::dvec3 p(0.3, -0.2, 4);
  const auto column = [&](const Camera& c) { return c.fx * p.x / p.z + c.cx; };
  EXPECT_DOUBLE_EQ(2 * column(half.camera), column(view.camera));
}

TEST(Pyramid, StopsBeforeViewsBecomeTooSmall) {
  const std::vector<View> views = {gradient_view(80, 72), gradient_view(160, 80)};
  const ViewPyramid pyramid(views, 4);
  EXPECT_EQ(pyramid.at(0)[0].camera.width, 80);
  EXPECT_EQ(pyramid.at(1)[1].camera.width, 80);
  EXPECT_EQ(pyramid.at(2)[0].camera.height, 18);
  EXPECT_EQ(pyramid.at(3)[0].camera.height, 18);  // 9 would be below 16
  EXPECT_EQ(ViewPyramid(views, 0).at(3)[0].camera.width, 80);
}

}  // namespace
}  // namespace fluxgs
