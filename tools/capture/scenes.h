// The scenes there are, each hard in its own way.
#pragma once

#include <cstdint>

#include "tools/capture/scene.h"

namespace fluxgs::capture {

enum class SceneKind {
  kSpheres,  ///< glossy spheres on a marble floor before a wall
  kOutdoor,  ///< bushes and rocks on grass; trees, hills and clouds far away
  kRoom,     ///< an indoor room from inside, with white walls that show hardly anything
  kWall      ///< bricks and plaster with grain down to a pixel, and stones that stick out
};

Scene make_scene(std::uint32_t seed, SceneKind kind = SceneKind::kSpheres);

}  // namespace fluxgs::capture
