// A splat cloud in the GPU's memory.
#pragma once

#include <cstdint>
#include <vector>

#include "fluxgs/splat_degree.h"
#include "gl/buffer.h"
#include "render/render_cloud.h"
#include "render/scene_packing.h"

namespace fluxgs::render {

/// Fails where the arrays of the cloud differ in length or its degree is none.
Expected<void> check_cloud(const RenderCloud& cloud);

/// Number of splats of a scene that the driver's limits allow, whichever they are.
std::uint64_t max_splats(const gl::Capabilities& driver, const DegreeCounts& scene);

/// Fails where the driver's limits are too small for a scene.
Expected<void> check_size(const gl::Capabilities& driver, const DegreeCounts& scene);

/// The buffers of a scene. Nothing is allocated after create().
struct SceneBuffers {
  std::uint32_t count = 0;  ///< splats
  gl::Buffer geometry, sh;

  /// Takes all that the packer has, which must be all of the scene. `positions`, unless null, get
  /// where each splat lies, as add_positions() has it. Fails where memory is short.
  static Expected<SceneBuffers> create(gl::Api& api, ScenePacker& packer,
                                       std::vector<glm::vec3>* positions = nullptr);
};

}  // namespace fluxgs::render
