#include "trainer/data/rectify.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <glm/vec2.hpp>

#include <opencv2/imgproc.hpp>

#include "trainer/data/lens_distortion.h"

namespace fluxgs {
namespace {

using glm::dvec2;

/// A part of the plane z = 1.
struct Rectangle {
  dvec2 low{0.0}, high{0.0};
};

dvec2 place_of(const Lens& lens, const dvec2& pixel) {
  return {(pixel.x - lens.cx) / lens.fx, (pixel.y - lens.cy) / lens.fy};
}

dvec2 pixel_of(const Lens& lens, const dvec2& place) {
  return {place.x * lens.fx + lens.cx, place.y * lens.fy + lens.cy};
}

constexpr int kBorderSteps = 32;  // places of each side of the image

/// The largest rectangle whose sides lie inside of the rays of the image's border. Nothing where
/// the middle of a side shows no ray, since distortion folds the image before it.
std::optional<Rectangle> inner_rectangle(const Lens& lens) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Rectangle inner{dvec2(-kInfinity), dvec2(kInfinity)};
  const dvec2 size(lens.width, lens.height);
  for (int axis = 0; axis < 2; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i <= kBorderSteps; ++i) {
        dvec2 pixel;
        pixel[axis] = side * size[axis];
        pixel[1 - axis] = size[1 - axis] * i / kBorderSteps;
        const RayOfPlace found = undistort(lens, place_of(lens, pixel));
        if (!found.reached && found.folded && i == kBorderSteps / 2) return std::nullopt;
        if (side == 0)
          inner.low[axis] = std::max(inner.low[axis], found.ray[axis]);
        else
          inner.high[axis] = std::min(inner.high[axis], found.ray[axis]);
      }
  return inner;
}

/// True if the lens sees all of a rectangle's border.
bool sees(const Lens& lens, const Rectangle& r) {
  for (int i = 0; i <= kBorderSteps; ++i) {
    const double t = static_cast<double>(i) / kBorderSteps;
    const dvec2 at = r.low + t * (r.high - r.low);
    for (const dvec2& ray : {dvec2(at.x, r.low.y), dvec2(at.x, r.high.y), dvec2(r.low.x, at.y),
                             dvec2(r.high.x, at.y)}) {
      const auto place = distort(lens, ray);
      if (!place) return false;
      const dvec2 pixel = pixel_of(lens, *place);
      constexpr double kSlack = 1e-3;  // pixels
      const bool inside = pixel.x > -kSlack && pixel.y > -kSlack && pixel.x < lens.width + kSlack &&
                          pixel.y < lens.height + kSlack;
      if (!inside) return false;
    }
  }
  return true;
}

/// The pinhole whose image is that rectangle.
Lens pinhole_of(const Lens& lens, const Rectangle& r) {
  Lens pinhole{.model = LensModel::kPerspective, .width = lens.width, .height = lens.height};
  pinhole.fx = lens.width / (r.high.x - r.low.x);
  pinhole.fy = lens.height / (r.high.y - r.low.y);
  pinhole.cx = -r.low.x * pinhole.fx;
  pinhole.cy = -r.low.y * pinhole.fy;
  return pinhole;
}

/// True if a pinhole is a camera, and one like the lens: an image stretched more than tenfold comes
/// from coefficients that are wrong.
bool is_plausible(const Lens& pinhole, const Lens& lens) {
  const auto near = [](double a, double b) { return a > b / 10 && a < b * 10; };
  return near(pinhole.fx, lens.fx) && near(pinhole.fy, lens.fy) && std::isfinite(pinhole.cx) &&
         std::isfinite(pinhole.cy);
}

/// The pinhole of the inner rectangle, which is made smaller about its middle until the lens sees
/// all of it.
std::optional<Lens> inner_pinhole(const Lens& lens) {
  const auto widest = inner_rectangle(lens);
  if (!widest) return std::nullopt;
  const dvec2 middle = 0.5 * (widest->low + widest->high);
  for (double scale = 1; scale > 0.5; scale *= 0.98) {
    const Rectangle r{middle + scale * (widest->low - middle),
                      middle + scale * (widest->high - middle)};
    if (!(r.low.x < r.high.x) || !(r.low.y < r.high.y)) return std::nullopt;
    if (!sees(lens, r)) continue;
    const Lens pinhole = pinhole_of(lens, r);
    return is_plausible(pinhole, lens) ? std::optional(pinhole) : std::nullopt;
  }
  return std::nullopt;
}

/// False where a pixel of the pinhole has no place in the image.
bool make_maps(const Lens& lens, Rectification& r) {
  constexpr double kCornerToCentre = 0.5;  // OpenCV counts from the centre of the first pixel
  r.map_x.create(lens.height, lens.width, CV_32FC1);
  r.map_y.create(lens.height, lens.width, CV_32FC1);
  std::atomic<bool> complete = true;
  tbb::parallel_for(0, lens.height, [&](int y) {
    for (int x = 0; x < lens.width; ++x) {
      const dvec2 ray = place_of(r.pinhole, {x + kCornerToCentre, y + kCornerToCentre});
      const auto place = distort(lens, ray);
      if (!place) {
        complete = false;
        return;
      }
      const dvec2 pixel = pixel_of(lens, *place);
      r.map_x.at<float>(y, x) = static_cast<float>(pixel.x - kCornerToCentre);
      r.map_y.at<float>(y, x) = static_cast<float>(pixel.y - kCornerToCentre);
    }
  });
  return complete;
}

}  // namespace

Expected<Rectification> make_rectification(const Lens& lens, const std::string& file) {
  Rectification result{.pinhole = lens, .map_x = {}, .map_y = {}};
  if (!is_distorted(lens)) return result;
  const auto pinhole = inner_pinhole(lens);
  if (pinhole) result.pinhole = *pinhole;
  if (pinhole && make_maps(lens, result)) return result;
  if (lens.cx < 0 || lens.cy < 0 || lens.cx > lens.width || lens.cy > lens.height)
    return fail(
        file, "principal point",
        fmt::format("{:g}, {:g} lies outside of the image of {}x{}, and the distortion around "
                    "it cannot be undone; check cx and cy",
                    lens.cx, lens.cy, lens.width, lens.height));
  return fail(file, "distortion",
              "cannot be undone: it folds the image before its border; check the coefficients");
}

cv::Mat rectify(const cv::Mat& view, const Rectification& rectification) {
  if (rectification.map_x.empty()) return view;
  cv::Mat result;
  cv::remap(view, result, rectification.map_x, rectification.map_y, cv::INTER_CUBIC,
            cv::BORDER_REPLICATE);
  return result;
}

}  // namespace fluxgs
