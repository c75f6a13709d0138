// Camera paths from files.
#pragma once

#include <string>
#include <vector>

#include "camera/path.h"
#include "tools/fluxgs/cameras/cameras.h"

namespace fluxgs::cli {

/// SuperSplat's settings.json; or a list of cameras as cameras_from_file() takes it, which is gone
/// through at constant speed, three seconds from each to the next.
Expected<camera::CameraPath> path_from_file(const std::string& path);

/// The cameras of a path's frames, so many a second, "000" and so on; those that repeat end before
/// the first one comes again, those that return at the far end. Fails on more than 10,000.
Expected<std::vector<Camera>> cameras_along(const camera::CameraPath& path, double fps,
                                            const ImageSize& size);

}  // namespace fluxgs::cli
