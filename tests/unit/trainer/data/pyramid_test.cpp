// Smaller photos for the coarse start.
#include "trainer/data/pyramid.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace fluxgs {
namespace {

Photo gradient_photo(int width, int height) {
  Photo photo{test::camera_in_front(width, height), Image<std::uint8_t>(width, height, 3), "a"};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        photo.rgb.at(x, y)[c] = static_cast<std::uint8_t>(2 * x + 3 * y + c);
  return photo;
}

TEST(Pyramid, AHalvedPhotoShowsTheMeansAndItsCameraSeesTheSame) {
  const Photo photo = gradient_photo(41, 30), half = halved(photo);
  ASSERT_EQ(half.camera.width, 20);
  ASSERT_EQ(half.camera.height, 15);
  for (int y = 0; y < 15; ++y)
    for (int x = 0; x < 20; ++x)
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(half.rgb.at(x, y)[c], (4 * (4 * x + 6 * y + c) + 2 * 5 + 2) / 4);
  // A point lands on the same place of the picture
  const glm::dvec3 p(0.3, -0.2, 4);
  const auto column = [&](const Camera& c) { return c.fx * p.x / p.z + c.cx; };
  EXPECT_DOUBLE_EQ(2 * column(half.camera), column(photo.camera));
}

TEST(Pyramid, StopsBeforePhotosBecomeTooSmall) {
  const std::vector<Photo> photos = {gradient_photo(80, 72), gradient_photo(160, 80)};
  const PhotoPyramid pyramid(photos, 4);
  EXPECT_EQ(pyramid.at(0)[0].camera.width, 80);
  EXPECT_EQ(pyramid.at(1)[1].camera.width, 80);
  EXPECT_EQ(pyramid.at(2)[0].camera.height, 18);
  EXPECT_EQ(pyramid.at(3)[0].camera.height, 18);  // 9 would be below 16
  EXPECT_EQ(PhotoPyramid(photos, 0).at(3)[0].camera.width, 80);
}

}  // namespace
}  // namespace fluxgs
