// Distortion: after undoing it, points land where the pinhole camera says.
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "test_files.h"
#include "trainer/data/lens_distortion.h"
#include "trainer/data/rectify.h"

namespace fluxgs {
namespace {

using namespace test;

/// Where the real lens puts a point of camera space, by OpenCV's own projection; pixels in our
/// convention.
glm::dvec2 project_distorted(const Lens& lens, const cv::Point3d& point) {
  const cv::Matx33d camera(lens.fx, 0, lens.cx - 0.5, 0, lens.fy, lens.cy - 0.5, 0, 0, 1);
  const std::vector<cv::Point3d> points{point};
  std::vector<cv::Point2d> pixels;
  if (lens.model == LensModel::kFisheye) {
    const cv::Vec4d k(lens.distortion[0], lens.distortion[1], lens.distortion[2],
                      lens.distortion[3]);
    cv::fisheye::projectPoints(points, pixels, cv::Vec3d(), cv::Vec3d(), camera, k);
  } else {
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera, lens.distortion, pixels);
  }
  return {pixels[0].x + 0.5, pixels[0].y + 0.5};
}

/// A grey image with a Gaussian dot at each place (px, our convention).
cv::Mat draw_dots(const Lens& lens, const std::vector<glm::dvec2>& places) {
  cv::Mat image(lens.height, lens.width, CV_32FC1, cv::Scalar(0));
  for (const auto& place : places)
    for (int y = 0; y < lens.height; ++y)
      for (int x = 0; x < lens.width; ++x) {
        const double dx = x + 0.5 - place.x, dy = y + 0.5 - place.y;
        image.at<float>(y, x) += static_cast<float>(200 * std::exp(-(dx * dx + dy * dy) / 8));
      }
  cv::Mat bytes, rgb;
  image.convertTo(bytes, CV_8U);
  cv::cvtColor(bytes, rgb, cv::COLOR_GRAY2RGB);
  return rgb;
}

/// The centre of mass of brightness within 7 px of a place.
glm::dvec2 centroid(const cv::Mat& image, const glm::dvec2& near) {
  double sum = 0, x_sum = 0, y_sum = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      if (std::hypot(x + 0.5 - near.x, y + 0.5 - near.y) > 7) continue;
      const double weight = image.at<cv::Vec3b>(y, x)[0];
      sum += weight;
      x_sum += weight * (x + 0.5);
      y_sum += weight * (y + 0.5);
    }
  return {x_sum / sum, y_sum / sum};
}

/// Draw a grid of points as the lens sees it, undistort, and measure against the pinhole. Returns
/// the number of points checked.
int check_lens_is_undone(const Lens& lens) {
  std::vector<cv::Point3d> points;
  std::vector<glm::dvec2> places;
  for (double y = -0.6; y <= 0.61; y += 0.2)
    for (double x = -0.8; x <= 0.81; x += 0.2) {
      points.emplace_back(2 * x, 2 * y, 2.0);
      places.push_back(project_distorted(lens, points.back()));
    }
  const auto rectification = make_rectification(lens, "image.jpg");
  EXPECT_TRUE(rectification) << rectification.error().message();
  const cv::Mat image = rectify(draw_dots(lens, places), *rectification);
  const Lens& pinhole = rectification->pinhole;
  EXPECT_EQ(image.cols, lens.width);
  EXPECT_EQ(image.rows, lens.height);
  int checked = 0;
  for (const auto& p : points) {
    const glm::dvec2 expected(pinhole.fx * p.x / p.z + pinhole.cx,
                              pinhole.fy * p.y / p.z + pinhole.cy);
    const bool inside = expected.x > 9 && expected.y > 9 && expected.x < lens.width - 9 &&
                        expected.y < lens.height - 9;
    if (!inside) continue;
    const glm::dvec2 found = centroid(image, expected);
    EXPECT_LT(glm::distance(found, expected), 0.15) << expected.x << ", " << expected.y;
    ++checked;
  }
  return checked;
}

TEST(Rectify, PerspectiveDistortionIsUndone) {
  Lens lens{.width = 320, .height = 240, .fx = 200, .fy = 205, .cx = 163, .cy = 118};
  lens.distortion = {-0.21, 0.06, 2e-3, -1e-3};
  EXPECT_GT(check_lens_is_undone(lens), 30);
  lens.distortion = {0.12, -0.03, -1e-3, 2e-3};
  EXPECT_GT(check_lens_is_undone(lens), 30);
  lens.distortion = {0.3, 0.1, 0, 0, 0.01, 0.4, 0.12, 0.02};
  EXPECT_GT(check_lens_is_undone(lens), 30);
}

TEST(Rectify, FisheyeIsUndone) {
  Lens lens{.model = LensModel::kFisheye,
            .width = 320,
            .height = 240,
            .fx = 190,
            .fy = 190,
            .cx = 160,
            .cy = 120};
  EXPECT_GT(check_lens_is_undone(lens), 30);
  lens.distortion = {0.05, -0.01, 0.002, 0};
  EXPECT_GT(check_lens_is_undone(lens), 30);
}

TEST(Rectify, NoPixelIsMadeUp) {
  for (const double k1 : {-0.25, -0.1, 0.1, 0.2}) {
    Lens lens{.width = 320, .height = 240, .fx = 220, .fy = 220, .cx = 160, .cy = 120};
    lens.distortion = {k1};
    const auto r = make_rectification(lens, "");
    ASSERT_TRUE(r) << k1;
    double x0, x1, y0, y1;
    cv::minMaxLoc(r->map_x, &x0, &x1);
    cv::minMaxLoc(r->map_y, &y0, &y1);
    // Inside the image, whose outermost pixels' centres are at 0 and 319, 239 here.
    EXPECT_GT(x0, -0.5) << k1;
    EXPECT_GT(y0, -0.5) << k1;
    EXPECT_LT(x1, 319.5) << k1;
    EXPECT_LT(y1, 239.5) << k1;
  }
}

/// A lens of every model, with distortion that it is made for.
std::vector<Lens> lenses() {
  Lens base{.width = 320, .height = 240, .fx = 200, .fy = 205, .cx = 163, .cy = 118};
  const auto with = [&](LensModel model, decltype(Lens::distortion) k) {
    Lens lens = base;
    lens.model = model;
    lens.distortion = k;
    return lens;
  };
  return {with(LensModel::kPerspective, {-0.21, 0.06, 2e-3, -1e-3}),
          with(LensModel::kPerspective, {0.3, 0.1, 0, 0, 0.01, 0.4, 0.12, 0.02}),
          with(LensModel::kFisheye, {0.05, -0.01, 0.002}),
          with(LensModel::kFieldOfView, {0.9}),
          with(LensModel::kDivision, {-0.2}),
          with(LensModel::kDivision, {0.1}),
          with(LensModel::kEucm, {0.6, 1.1}),
          with(LensModel::kThinPrismFisheye, {0.03, 0.01, 1e-3, -2e-3, 1e-3, 0, 2e-3, 1e-3}),
          with(LensModel::kRadTanThinPrismFisheye,
               {0.02, 0.01, -2e-3, 0, 0, 0, 1e-3, -1e-3, 2e-3, 0, -1e-3, 1e-4})};
}

TEST(LensDistortion, InverseComesBackForEveryModel) {
  for (const Lens& lens : lenses())
    for (double y = -0.6; y < 0.61; y += 0.2)
      for (double x = -0.8; x < 0.81; x += 0.2) {
        const glm::dvec2 ray(x, y);
        const auto place = distort(lens, ray);
        ASSERT_TRUE(place);
        const RayOfPlace back = undistort(lens, *place);
        ASSERT_TRUE(back.reached) << static_cast<int>(lens.model) << " " << x << " " << y;
        EXPECT_LT(glm::distance(back.ray, ray), 1e-9) << static_cast<int>(lens.model);
      }
}

// By hand: the identities of each model.
TEST(LensDistortion, KnownPlaces) {
  const auto place = [](LensModel model, decltype(Lens::distortion) k, glm::dvec2 ray) {
    Lens lens{.model = model, .width = 2, .height = 2, .fx = 1, .fy = 1};
    lens.distortion = k;
    return *distort(lens, ray);
  };
  EXPECT_NEAR(place(LensModel::kFisheye, {}, {1, 0}).x, std::atan(1.0), 1e-15);
  // tan(ω/2) = 1/2: r' = atan(r)/ω
  const double omega = 2 * std::atan(0.5);
  EXPECT_NEAR(place(LensModel::kFieldOfView, {omega}, {0, 2}).y, std::atan(2.0) / omega, 1e-15);
  // x = x'/(1 + k·x'²) with k = 1/4, x' = 2: x = 1
  EXPECT_NEAR(place(LensModel::kDivision, {0.25}, {1, 0}).x, 2, 1e-7);
  // α = 1/2, β = 1: a stereographic projection, x/(½·√(x² + 1) + ½)
  EXPECT_NEAR(place(LensModel::kEucm, {0.5, 1}, {0.75, 0}).x, 0.75 / 1.125, 1e-15);
  EXPECT_NEAR(place(LensModel::kThinPrismFisheye, {0, 0, 0, 0, 0, 0, 1, 0}, {1, 0}).x,
              std::atan(1.0) + std::pow(std::atan(1.0), 2), 1e-15);
  EXPECT_NEAR(place(LensModel::kRadTanThinPrismFisheye, {1}, {1, 0}).x,
              std::atan(1.0) + std::pow(std::atan(1.0), 3), 1e-15);
}

// The monotone edge of 1 + k·r²: r = 1/√(−3k).
TEST(LensDistortion, EndsWhereItFolds) {
  Lens lens{.width = 2, .height = 2, .fx = 1, .fy = 1};
  lens.distortion = {-0.3};
  const double edge = 1 / std::sqrt(0.9);
  const RayOfPlace found = undistort(lens, {2, 0});
  EXPECT_FALSE(found.reached);
  EXPECT_TRUE(found.folded);
  EXPECT_NEAR(found.ray.x, edge, 0.01);
  EXPECT_LT(found.ray.x, edge);
}

TEST(Rectify, NothingHappensWithoutDistortion) {
  const Lens lens{.width = 32, .height = 24, .fx = 20, .fy = 20, .cx = 16, .cy = 12};
  const auto r = make_rectification(lens, "");
  ASSERT_TRUE(r);
  EXPECT_EQ(r->pinhole, lens);
  const cv::Mat image(24, 32, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(rectify(image, *r).data, image.data);
}

TEST(RectifyBadInput, ImpossibleCoefficientsAreRefused) {
  for (const double k1 : {1e300, -1e300, 1e9, -50.0, 1e4}) {
    Lens lens{.width = 320, .height = 240, .fx = 220, .fy = 220, .cx = 160, .cy = 120};
    lens.distortion = {k1};
    expect_failure(make_rectification(lens, "image.jpg"), "image.jpg", "distortion");
  }
}

// A fisheye of more than 180 degrees is cut to what a pinhole can show.
TEST(Rectify, WiderThanAPinholeIsCut) {
  const Lens wide{.model = LensModel::kFisheye,
                  .width = 320,
                  .height = 240,
                  .fx = 60,
                  .fy = 60,
                  .cx = 160,
                  .cy = 120};
  const auto r = make_rectification(wide, "image.jpg");
  ASSERT_TRUE(r) << r.error().message();
  EXPECT_GT(160 / r->pinhole.fx, 1.5);
  EXPECT_LT(std::hypot(160 / r->pinhole.fx, 120 / r->pinhole.fy), 2 * kMaxRay);
}

}  // namespace
}  // namespace fluxgs
