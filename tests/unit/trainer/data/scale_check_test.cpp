// Coordinates that are too large or too small are said to be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "trainer/data/scale_check.h"

namespace fluxgs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A camera that looks from a place to another.
Photo photo_from(const glm::dvec3& from, const glm::dvec3& to) {
  const glm::dvec3 z = glm::normalize(to - from);
  const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), z));
  const glm::dmat3 rotation = glm::transpose(glm::dmat3(x, glm::cross(z, x), z));
  return {.camera = {.name = "",
                     .width = 640,
                     .height = 480,
                     .fx = 500,
                     .fy = 500,
                     .cx = 320,
                     .cy = 240,
                     .rotation = rotation,
                     .translation = -(rotation * from)},
          .rgb = {},
          .path = ""};
}

/// Cameras around a point, `size` away from it.
Dataset around(const glm::dvec3& center, double size) {
  Dataset data;
  for (const glm::dvec3& from :
       {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(-0.6, 0, 0.8)})
    data.train.push_back(photo_from(center + size * from, center));
  return data;
}

TEST(ScaleCheck, OrdinaryScenesAreFine) {
  for (const double size : {0.1, 1.0, 100.0, 1e6})
    EXPECT_THAT(scale_warnings(around({0, 0, 0}, size)), IsEmpty()) << size;
  EXPECT_THAT(scale_warnings(around({1000, 0, 0}, 3)), IsEmpty());
}

TEST(ScaleCheck, DepthIsThatOfTheViewsOrOfThePoints) {
  Dataset data = around({7, 8, 9}, 3);
  EXPECT_NEAR(typical_depth(data).value(), 3, 1e-9);
  data.points.assign(5, glm::vec3(7, 8, 9.5F));
  EXPECT_NEAR(typical_depth(data).value(), 3, 0.51);
  data.train.resize(1);
  data.points.clear();
  EXPECT_FALSE(typical_depth(data));  // one view meets no other
  EXPECT_THAT(scale_warnings(data), IsEmpty());
}

// Coordinates of a map in metres: 5e6 · 2^-24 is 0.3 m, at 5 m and 500 px 30 pixels
TEST(ScaleCheck, FarFromTheOriginFloatsAreTooCoarse) {
  EXPECT_THAT(scale_warnings(around({5e5, 5e6, 0}, 5)),
              ElementsAre(HasSubstr("wrong by up to 30 pixels")));
}

TEST(ScaleCheck, WithinTheNearPlaneNothingIsDrawn) {
  EXPECT_THAT(scale_warnings(around({0, 0, 0}, 0.02)), ElementsAre(HasSubstr("0.02 units away")));
}

}  // namespace
}  // namespace fluxgs
