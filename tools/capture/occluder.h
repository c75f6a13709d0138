// Somebody who walks through a capture: in each photo at another place, before everything else.
#pragma once

#include <cstdint>

#include "fluxgs/camera.h"
#include "fluxgs/image.h"
#include "tools/capture/scene.h"

namespace fluxgs::capture {

/// The scene with a ball in a loud colour before this camera, on a random ray of it; another one
/// for each seed. It hides about a tenth of the image, and is the last of the spheres.
Scene with_occluder(Scene scene, const Camera& camera, std::uint64_t seed);

/// An RGB image that is black where a pixel, or a neighbour, shows the scene's last sphere, and
/// white elsewhere.
Image<std::uint8_t> occluder_mask(const Scene& scene, const Camera& camera);

}  // namespace fluxgs::capture
