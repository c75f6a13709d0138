// Distortion of a lens, forward and inverse, for every camera model that is read.
#pragma once

#include <optional>

#include <glm/vec2.hpp>

#include "trainer/data/lens.h"

namespace fluxgs {

/// The place on the lens's image plane, before focal length and principal point, of the ray
/// (x, y, 1). Nothing where the model has no value. Sources: OpenCV's calib3d (perspective,
/// fisheye: Kannala & Brandt 2006), Devernay & Faugeras 2001 (field of view), Fitzgibbon 2001
/// (division), Khomutenko et al. 2016 (EUCM), Weng et al. 1992 (thin prism), Project Aria
/// (radial, tangential and thin prism); parameters in COLMAP's order (Lens::distortion).
std::optional<glm::dvec2> distort(const Lens& lens, const glm::dvec2& ray);

/// The farthest ray from the axis that a pinhole image is made of: 70 degrees.
inline constexpr double kMaxRay = 2.7474774194546216;

/// The end of the way from the axis to the ray that a place on the image plane shows.
struct RayOfPlace {
  glm::dvec2 ray{0.0};
  bool reached = false;  ///< it is that ray, to 1e-9
  bool folded = false;   ///< not reached: from here on distortion moves places inwards again
};

/// The inverse of distort(), by Newton's method along the line from the centre to `place`. Ends
/// before the place where distortion stops to be monotone (folded), or at kMaxRay.
RayOfPlace undistort(const Lens& lens, const glm::dvec2& place);

}  // namespace fluxgs
