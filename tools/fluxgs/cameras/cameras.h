// Cameras from a file, image sizes, and cameras that look at a point.
#pragma once

#include <string>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "trainer/data/image_io.h"

namespace fluxgs::cli {

/// "WxH", 1…16384 each.
Expected<ImageSize> parse_size(const std::string& text);

/// A camera at `eye` that looks at `target`, with square pixels and the principal point in the
/// centre; fov_y in radians. `up` is not parallel to the view.
Camera look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up, double fov_y,
               const ImageSize& size);

/// The same view in another size: the intrinsics are scaled with each side.
Camera resized(Camera camera, const ImageSize& size);

/// Cameras of a JSON list of {"name", "position", "target", "up", "fovY" in degrees}, in the
/// coordinates of the scene as an INRIA .ply stores it; square pixels, principal point in the
/// centre. Errors name the file, the entry and the key.
Expected<std::vector<Camera>> cameras_from_file(const std::string& path, const ImageSize& size);

}  // namespace fluxgs::cli
