#include "platform/web/scene_blocks.h"

#include <vector>

namespace fluxgs::web {

SceneHead head_of(const viewer::LoadedScene& scene) {
  return {.count = scene.cloud.size(),
          .sh_degree = scene.cloud.sh_degree,
          .file_splats = scene.cloud.file_splats,
          .file_sh_degree = scene.cloud.file_sh_degree,
          .filter = scene.cloud.base.filter,
          .dropped = scene.dropped,
          .start = scene.start,
          .is_coarse = scene.is_coarse};
}

viewer::LoadedScene scene_with(const SceneHead& head) {
  viewer::LoadedScene scene;
  scene.cloud.base.filter = head.filter;
  scene.cloud.base.resize(head.count);
  scene.cloud.sh_degree = head.sh_degree;
  scene.cloud.sh.resize(head.count * scene.cloud.sh_size());
  scene.cloud.file_splats = head.file_splats;
  scene.cloud.file_sh_degree = head.file_sh_degree;
  scene.dropped = head.dropped;
  scene.start = head.start;
  scene.is_coarse = head.is_coarse;
  return scene;
}

std::array<Block, kBlocks> blocks_of(viewer::LoadedScene& scene) {
  const auto block = []<class T>(std::vector<T>& array) {
    return Block{array.data(), sizeof(T) * array.size()};
  };
  SplatCloud& base = scene.cloud.base;
  return {block(base.positions),      block(base.log_scales), block(base.rotations),
          block(base.opacity_logits), block(base.sh_dc),      block(scene.cloud.sh)};
}

}  // namespace fluxgs::web
