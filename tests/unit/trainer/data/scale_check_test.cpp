// Coordinates that are too large or too small are said to be.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/scenes.h"
#include "trainer/data/scale_check.h"

namespace fluxgs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A camera that looks from a place to another, of focal length 500 px.
View view_from(const glm::dvec3& from, const glm::dvec3& to) {
  View view{test::camera_at(from, to, 640, 480), {}, {}};
  view.camera.fx = view.camera.fy = 500;
  return view;
}

/// Cameras around a point, `size` away from it.
Dataset around(const glm::dvec3& center, double size) {
  Dataset data;
  for (const glm::dvec3& from :
       {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(-0.6, 0, 0.8)})
    data.train.push_back(view_from(center + size * from, center));
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
  data.points.assign(5, glm::vec3(7, 8, 9.5F));  // half a unit nearer along the second view
  EXPECT_NEAR(typical_depth(data).value(), 2.6, 1e-6);
  data.points.assign(5, glm::vec3(7, 100, 9));  // the views are level: at the depth of the centre
  EXPECT_NEAR(typical_depth(data).value(), 3, 1e-5);
  data.train.resize(1);
  data.points.clear();
  EXPECT_FALSE(typical_depth(data));  // one view meets no other
  EXPECT_THAT(scale_warnings(data), IsEmpty());
}

TEST(ScaleCheck, CamerasThatLookPastThePoints) {
  Dataset data = around({0, 0, 0}, 3);
  for (int i = 0; i < 200; ++i)
    data.points.emplace_back(0.3 * std::sin(i), 0.3 * std::sin(3 * i), 0.3 * std::cos(i));
  EXPECT_THAT(scale_warnings(data), IsEmpty());
  for (View& view : data.train) {  // y up and z backward taken for y down and z forward
    view.camera.rotation = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1) * view.camera.rotation;
    view.camera.translation = view.camera.translation * glm::dvec3(1, -1, -1);
  }
  EXPECT_THAT(scale_warnings(data), testing::Contains(HasSubstr("none of the sparse points")));
}

/// Cameras that look outward from about one place.
Dataset panorama(const glm::dvec3& center, double shake) {
  Dataset data;
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 out(std::cos(i * 0.5236), 0.1, std::sin(i * 0.5236));
    const glm::dvec3 from =
        center + shake * glm::dvec3(std::cos(7.0 * i), std::sin(3.0 * i), std::sin(5.0 * i));
    data.train.push_back(view_from(from, from + out));
  }
  return data;
}

TEST(ScaleCheck, PanoramasSeeFartherThanTheirCamerasAreApart) {
  for (const double shake : {0.0, 1e-9, 0.01, 0.02, 0.03, 0.1})
    for (const glm::dvec3& center : {glm::dvec3(1.3, 0.7, 1.6), glm::dvec3(300, 0, 0)})
      EXPECT_THAT(scale_warnings(panorama(center, shake)), IsEmpty()) << shake;
}

TEST(ScaleCheck, AFlightOverAMap) {
  const auto flight = [](const glm::dvec3& start) {
    Dataset data;
    for (int i = 0; i < 6; ++i) {
      const glm::dvec3 from = start + glm::dvec3(10.0 * i, 0, 0);
      data.train.push_back(view_from(from, from + glm::dvec3(0, 1e-9, -60)));
    }
    return data;
  };
  EXPECT_THAT(scale_warnings(flight({5e5, 5e6, 60})), ElementsAre(HasSubstr("from the origin")));
  EXPECT_THAT(scale_warnings(flight({0, 0, 60})), IsEmpty());
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
