// A splat cloud in the GPU's memory.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fluxgs/splat_cloud.h"
#include "gl/buffer.h"

namespace fluxgs::render {

/// The cloud as the projection pass reads it (shaders/project.comp), all in float32.
struct PackedScene {
  glm::dvec3 origin{0.0};                       ///< positions are relative to this world point
  int sh_degree = 0;                            ///< 0…3
  std::uint32_t harmonics_stride = 0;           ///< vec4s per splat in `harmonics`
  std::vector<std::array<float, 4>> geometry;   ///< 4 per splat
  std::vector<std::array<float, 4>> harmonics;  ///< harmonics_stride per splat
  std::size_t undrawable = 0;  ///< splats with an attribute that is not finite or is beyond 1e15
};

/// vec4s per splat that hold the coefficients of degrees 1…degree: groups of four, three vec4s
/// each.
constexpr std::uint32_t harmonics_stride(int degree) {
  return 3U * static_cast<std::uint32_t>((sh_rest_count(degree) + 3) / 4);
}

/// The origin is the median position: relative to it the coordinates of a scene that lies far from
/// the world's origin keep their bits. Undrawable splats keep their index and get opacity 0.
PackedScene pack_scene(const SplatCloud& cloud);

/// The buffers of a scene. Nothing is allocated after create().
struct SceneBuffers {
  std::uint32_t count = 0;
  int sh_degree = 0;
  std::uint32_t harmonics_stride = 0;
  glm::dvec3 origin{0.0};
  gl::Buffer geometry, harmonics;

  /// Fails where the arrays of the cloud differ in length, where the driver's limits are too small
  /// for it, or where memory is short; before anything is allocated in the first two cases.
  static Expected<SceneBuffers> create(gl::Api& api, const SplatCloud& cloud);
};

}  // namespace fluxgs::render
