#include "trainer/data/rectify.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace fluxgs {
namespace {

// OpenCV counts pixels from the centre of the first one, we (and COLMAP) from its corner.
constexpr double kCornerToCentre = 0.5;

cv::Matx33d to_opencv(const Lens& lens) {
  return {lens.fx, 0, lens.cx - kCornerToCentre, 0, lens.fy, lens.cy - kCornerToCentre, 0, 0, 1};
}

Lens to_pinhole(const cv::Matx33d& matrix, const Lens& lens) {
  return {.model = LensModel::kPerspective,
          .width = lens.width,
          .height = lens.height,
          .fx = matrix(0, 0),
          .fy = matrix(1, 1),
          .cx = matrix(0, 2) + kCornerToCentre,
          .cy = matrix(1, 2) + kCornerToCentre};
}

/// True if a pinhole found by OpenCV is a camera, and one like the lens: an image stretched
/// more than tenfold comes from coefficients that are wrong.
bool is_plausible(const Lens& pinhole, const Lens& lens) {
  const auto near = [](double a, double b) { return a > b / 10 && a < b * 10; };
  return near(pinhole.fx, lens.fx) && near(pinhole.fy, lens.fy) && std::isfinite(pinhole.cx) &&
         std::isfinite(pinhole.cy);
}

Rectification rectify_perspective(const Lens& lens) {
  const cv::Size size(lens.width, lens.height);
  const cv::Matx33d camera = to_opencv(lens);
  const cv::Mat coefficients(lens.distortion, true);
  // Its search for the inner rectangle ends at the size given (OpenCV 4.6), one pixel beyond the
  // last pixel's centre.
  const cv::Size centres(std::max(lens.width - 1, 1), std::max(lens.height - 1, 1));
  const cv::Matx33d inner = cv::getOptimalNewCameraMatrix(camera, coefficients, centres, 0.0, size);
  Rectification result{.pinhole = to_pinhole(inner, lens), .map_x = {}, .map_y = {}};
  if (is_plausible(result.pinhole, lens))
    cv::initUndistortRectifyMap(camera, coefficients, cv::noArray(), inner, size, CV_32FC1,
                                result.map_x, result.map_y);
  return result;
}

Rectification rectify_fisheye(const Lens& lens) {
  const cv::Size size(lens.width, lens.height);
  const cv::Matx33d camera = to_opencv(lens);
  const cv::Vec4d coefficients(lens.distortion[0], lens.distortion[1], lens.distortion[2],
                               lens.distortion[3]);
  cv::Matx33d inner;
  cv::fisheye::estimateNewCameraMatrixForUndistortRectify(camera, coefficients, size,
                                                          cv::Matx33d::eye(), inner, 0.0);
  Rectification result{.pinhole = to_pinhole(inner, lens), .map_x = {}, .map_y = {}};
  if (is_plausible(result.pinhole, lens))
    cv::fisheye::initUndistortRectifyMap(camera, coefficients, cv::Matx33d::eye(), inner, size,
                                         CV_32FC1, result.map_x, result.map_y);
  return result;
}

/// All of the image comes from inside the image, give or take the rounding of OpenCV's search.
bool maps_inside(const Rectification& r) {
  double x0, x1, y0, y1;
  cv::minMaxLoc(r.map_x, &x0, &x1);
  cv::minMaxLoc(r.map_y, &y0, &y1);
  const double slack_x = 2 + 0.02 * r.pinhole.width, slack_y = 2 + 0.02 * r.pinhole.height;
  return cv::checkRange(r.map_x) && cv::checkRange(r.map_y) && x0 > -slack_x && y0 > -slack_y &&
         x1 < r.pinhole.width + slack_x && y1 < r.pinhole.height + slack_y;
}

}  // namespace

Expected<Rectification> make_rectification(const Lens& lens, const std::string& file) {
  if (!is_distorted(lens)) return Rectification{.pinhole = lens, .map_x = {}, .map_y = {}};
  const auto impossible = [&] {
    return fail(file, "distortion",
                "cannot be undone, expected coefficients that bend the image only moderately "
                "(a view of less than 180 degrees)");
  };
  try {
    auto result =
        lens.model == LensModel::kFisheye ? rectify_fisheye(lens) : rectify_perspective(lens);
    if (result.map_x.empty() || !maps_inside(result)) return impossible();
    return result;
  } catch (const cv::Exception&) {  // OpenCV finds the numbers impossible as well.
    return impossible();
  }
}

cv::Mat rectify(const cv::Mat& view, const Rectification& rectification) {
  if (rectification.map_x.empty()) return view;
  cv::Mat result;
  cv::remap(view, result, rectification.map_x, rectification.map_y, cv::INTER_CUBIC,
            cv::BORDER_REPLICATE);
  return result;
}

}  // namespace fluxgs
