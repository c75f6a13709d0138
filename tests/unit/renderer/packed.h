// A cloud as the GPU gets it, in one piece.
#pragma once

#include "render/scene_packing.h"

namespace fluxgs::test {

struct Packed : render::PackedSplats {
  render::SceneConstants constants;
  std::size_t undrawable = 0;
};

inline Packed packed(const SplatCloud& of) {
  const render::RenderCloud cloud = of;
  render::ScenePacker packer(cloud);
  Packed result;
  packer.next(cloud.size(), result);
  result.constants = packer.constants();
  result.undrawable = packer.undrawable();
  return result;
}

}  // namespace fluxgs::test
