// Projected splats read back from the GPU, for tests and measurements.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "render/settings.h"

namespace fluxgs::render {

/// The twin of ProjectedSplat in shaders/projected_splat.glsl, which explains it.
struct ProjectedSplat {
  glm::vec2 centre{0.0F};  ///< px
  glm::vec3 factor{0.0F};  ///< xx, xy, yy
  float level = 0;         ///< log2 of the opacity
  glm::vec3 color{0.0F};
};

/// Their words (projected_splat_bytes() each), of an image of that size.
std::vector<ProjectedSplat> unpack_projected_splats(std::span<const std::uint32_t> words,
                                                    SplatPrecision precision, int width,
                                                    int height);

}  // namespace fluxgs::render
