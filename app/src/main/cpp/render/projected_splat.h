// Projected splats read back from the GPU, for tests and measurements.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "gl/buffer.h"
#include "render/settings.h"

namespace fluxgs::render {

/// The twin of ProjectedSplat in shaders/projected_splat.glsl, which explains it.
struct ProjectedSplat {
  glm::vec2 centre{0.0F};  ///< px
  glm::vec3 factor{0.0F};  ///< xx, xy, yy
  float level = 0;         ///< log2 of the opacity
  glm::vec3 color{0.0F};
};

/// The first `count` projected_splats of an image of that size. Waits for the GPU.
Expected<std::vector<ProjectedSplat>> read_projected_splats(const gl::Buffer& projected_splats,
                                                            std::uint32_t count,
                                                            SplatPrecision precision, int width,
                                                            int height);

}  // namespace fluxgs::render
