// The lens of a data set's camera: intrinsics with the distortion that is still in its images.
#pragma once

#include <array>
#include <compare>
#include <string>

#include "fluxgs/error.h"

namespace fluxgs {

enum class LensModel {
  kPerspective,             ///< pinhole, then OpenCV's rational and tangential distortion
  kFisheye,                 ///< equidistant, then a polynomial of the angle (cv::fisheye)
  kFieldOfView,             ///< COLMAP's FOV
  kDivision,                ///< COLMAP's SIMPLE_DIVISION and DIVISION
  kEucm,                    ///< the extended unified camera model
  kThinPrismFisheye,        ///< COLMAP's THIN_PRISM_FISHEYE
  kRadTanThinPrismFisheye,  ///< COLMAP's RAD_TAN_THIN_PRISM_FISHEYE, Project Aria's
};

struct Lens {
  LensModel model = LensModel::kPerspective;
  int width = 0, height = 0;  ///< pixels, of the image as stored
  double fx = 0, fy = 0;      ///< pixels
  double cx = 0, cy = 0;      ///< pixels; the centre of the first pixel is at (½, ½)
  /// Perspective: k1 k2 p1 p2 k3 k4 k5 k6, in OpenCV's order; fisheye: k1 k2 k3 k4; the others as
  /// COLMAP has them behind the principal point.
  std::array<double, 12> distortion{};

  auto operator<=>(const Lens&) const = default;
};

bool is_distorted(const Lens& lens);

/// The largest image that is read, in pixels: 1 GiB as RGBA.
inline constexpr long long kMaxPixels = 1LL << 28;

/// Refuse sizes and intrinsics that no camera has: sizes outside 1…kMaxPixels, focal lengths that
/// are not positive, anything not finite. `field` names the camera in the error.
Expected<void> check_lens(const Lens& lens, const std::string& file, const std::string& field);

/// The lens for an image of another size: everything in pixels is scaled, each way by itself.
Lens lens_for_image(const Lens& lens, int width, int height);

struct ImageSize {
  int width = 0, height = 0;  ///< pixels; 0: not known
};

/// True if an image of that size has the shape of its camera, but for rounding to whole pixels: it
/// is then the same image reduced or enlarged.
bool has_shape(const Lens& lens, ImageSize size);

}  // namespace fluxgs
