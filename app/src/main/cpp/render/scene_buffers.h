// A splat cloud in the GPU's memory.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fluxgs/splat_cloud.h"
#include "fluxgs/splat_degree.h"
#include "gl/buffer.h"
#include "render/scene_constants.h"

namespace fluxgs::render {

/// The cloud as the projection pass reads it (shaders/project.comp), all in float32.
struct PackedScene {
  SceneConstants constants;
  std::vector<std::array<float, 4>> geometry;   ///< 4 per splat; the last float is a uint
  std::vector<std::array<float, 4>> harmonics;  ///< harmonics_stride(its degree) per splat
  std::size_t undrawable = 0;  ///< splats with an attribute that is not finite or is beyond 1e15
};

/// vec4s of a splat that hold the coefficients of degrees 1…degree: groups of four, three vec4s
/// each.
constexpr std::uint32_t harmonics_stride(int degree) {
  return 3U * static_cast<std::uint32_t>((sh_rest_count(degree) + 3) / 4);
}

/// Bytes of the coefficients of a scene: each splat takes those of its own degree.
std::uint64_t harmonics_bytes(const DegreeCounts& splats);

/// So many splats of a scene (all, if it has fewer), those of high degrees first: whichever they
/// are, they take no more memory than these.
DegreeCounts largest_of(const DegreeCounts& scene, std::uint64_t count);

/// Fails where the arrays of the cloud differ in length or its degree is none.
Expected<void> check_cloud(const SplatCloud& cloud);

/// Relative to the median position the coordinates of a scene that lies far from the world's origin
/// keep their bits. Undrawable splats keep their index and get no opacity.
PackedScene pack_scene(const SplatCloud& cloud);

/// Where each splat lies, as PackedScene has it; NaN for undrawable ones.
std::vector<glm::vec3> positions_of(const PackedScene& scene);

/// How many splats of a scene the driver's limits allow, whichever they are.
std::uint64_t most_splats(const gl::Capabilities& driver, const DegreeCounts& scene);

/// check_cloud(); also fails where the driver's limits are too small for it.
Expected<void> check_scene(const gl::Capabilities& driver, const SplatCloud& cloud);

/// The buffers of a scene. Nothing is allocated after create().
struct SceneBuffers {
  SceneConstants constants;
  gl::Buffer geometry, harmonics;

  /// Fails where memory is short.
  static Expected<SceneBuffers> create(gl::Api& api, const PackedScene& scene);
};

}  // namespace fluxgs::render
