// The point that the cameras look at, and how far away it is.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "trainer/data/dataset.h"

namespace fluxgs {

struct Ray {
  glm::dvec3 origin, direction;  ///< of unit length
};

/// The point with the least sum of squared distances to some rays (as lines). Nothing if they are
/// parallel to within about half a degree, so that it could be anywhere.
std::optional<glm::dvec3> nearest_point_to_rays(const std::vector<Ray>& rays);

/// Rays from the centre of each camera along its view direction.
std::vector<Ray> view_rays(const std::vector<Camera>& cameras);

/// The ray through a pixel of an image, e.g. (i + ½, j + ½).
Ray pixel_ray(const Camera& camera, const glm::dvec2& pixel);

/// True if a camera has a point in its frame, in front of it.
bool in_frame(const Camera& camera, const glm::dvec3& point);

/// The diagonal of the bounding box of the cameras' positions, of which there is one at least.
double camera_spread(const std::vector<Camera>& cameras);

/// For each image, the distance along its view direction at which it sees the scene: to the point
/// nearest to all view directions. Where there is none, or it is behind the camera or almost at it
/// (parallel views, panoramas), the mean of the other images' distances, and without any the
/// diameter of the cameras' positions (1 if they are all the same).
std::vector<double> focus_distances(const std::vector<View>& views);

}  // namespace fluxgs
