// Which pictures to take: cameras from a data set, from a file, or around the scene.
#pragma once

#include <string>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

struct PictureSize {
  int width = 0, height = 0;  ///< px; 0: not given
};

/// "WxH", 1…16384 each.
Expected<PictureSize> parse_size(const std::string& text);

/// The same view in another size: the intrinsics are scaled with each side.
Camera resized(Camera camera, const PictureSize& size);

/// Cameras of a JSON list of {"name", "position", "target", "up", "fovY" in degrees}, in the
/// coordinates of the scene as an INRIA .ply stores it; square pixels, principal point in the
/// centre. Errors name the file, the entry and the key.
Expected<std::vector<Camera>> cameras_from_file(const std::string& path, const PictureSize& size);

/// `count` cameras on a circle that looks at the scene slightly from above. With photos the circle
/// follows theirs: their centre of attention, mean height, distance and up direction. Without, it
/// is fitted to the middle of the splats, y down.
std::vector<Camera> orbit(const SplatCloud& cloud, const std::vector<Photo>& photos, int count,
                          const PictureSize& size);

}  // namespace fluxgs::cli
