// The one camera: a pinhole in the OpenCV convention (x right, y down, z forward).
#pragma once

#include <string>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

namespace fluxgs {

/// A pinhole camera. Pixel (i, j) covers [i, i+1)×[j, j+1) and is sampled at its centre
/// (i + ½, j + ½); a point p of the world lands on (fx·x/z + cx, fy·y/z + cy), (x,y,z) = R·p + t.
struct Camera {
  std::string name;             ///< of its image, may be empty
  int width = 0;                ///< pixels, > 0
  int height = 0;               ///< pixels, > 0
  double fx = 0;                ///< horizontal focal length, pixels, > 0
  double fy = 0;                ///< vertical focal length, pixels, > 0
  double cx = 0;                ///< principal point from the left edge, pixels
  double cy = 0;                ///< principal point from the top edge, pixels
  glm::dmat3 rotation{1.0};     ///< R, world → camera (glm is column-major: rotation[column][row])
  glm::dvec3 translation{0.0};  ///< t

  /// The centre of projection in the world, −Rᵀt.
  glm::dvec3 center() const { return -(glm::transpose(rotation) * translation); }
  /// The unit direction of view in the world: the third row of R.
  glm::dvec3 forward() const { return {rotation[0][2], rotation[1][2], rotation[2][2]}; }
};

}  // namespace fluxgs
