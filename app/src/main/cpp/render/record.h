// What the draw knows of a splat, read back: for tests and measurements.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "gl/buffer.h"
#include "render/settings.h"

namespace fluxgs::render {

/// The twin of Record in shaders/record.glsl, which explains it.
struct Record {
  glm::vec2 centre{0.0F};  ///< px
  glm::vec3 factor{0.0F};  ///< xx, xy, yy
  float level = 0;         ///< log2 of the opacity
  glm::vec3 color{0.0F};
};

/// The first `count` records of an image of that size. Waits for the GPU.
Expected<std::vector<Record>> read_records(const gl::Buffer& records, std::uint32_t count,
                                           RecordPrecision precision, int width, int height);

}  // namespace fluxgs::render
