// Removes lens distortion: the image that a pinhole camera would have taken.
#pragma once

#include <cstdint>
#include <string>

#include <opencv2/core/mat.hpp>

#include "fluxgs/error.h"
#include "trainer/data/lens.h"

namespace fluxgs {

/// Source of each pixel of the undistorted image. For a lens without distortion the maps
/// are empty and the pinhole is the lens.
struct Rectification {
  Lens pinhole;          ///< same size, no distortion
  cv::Mat map_x, map_y;  ///< pixels of the image, OpenCV's convention (first centre at 0)
};

/// The pinhole camera of the same size whose whole image lies inside the image, so that no pixel
/// is made up, and within kMaxRay of the axis (lens_distortion.h). Fails where distortion folds
/// the image before the middle of a side.
Expected<Rectification> make_rectification(const Lens& lens, const std::string& file);

/// Resample an 8-bit image (bicubic).
cv::Mat rectify(const cv::Mat& view, const Rectification& rectification);

}  // namespace fluxgs
