// Points on what the cameras of a capture see, as structure from motion would find them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fluxgs/camera.h"
#include "tools/capture/scene.h"

namespace fluxgs::capture {

/// A .ply with `count` points (> 0): the surfaces at random pixels of random cameras, with the
/// colours that are seen there. Where a pixel shows the sky another one is taken; a scene that is
/// all sky gives fewer points. The same for the same seed.
std::string surface_points_ply(const Scene& scene, const std::vector<Camera>& cameras, int count,
                               std::uint64_t seed);

}  // namespace fluxgs::capture
