// Marks of pixels that layers, blended front to back, have made opaque: a depth in the tile's
// memory, which the GPU tests before it shades the fragments of later layers.
#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "gl/program.h"
#include "gl/vertex_array.h"

namespace fluxgs::render {

/// Layers that are drawn between begin() and end() are blended front to back. They come with their
/// colours multiplied by α, at a depth in the middle, and are not shaded where mark() found a pixel
/// finished. The framebuffer that is bound holds C in RGB and the transmittance T in A meanwhile,
/// so that T keeps its digits where it is small. Marks need a target that has room for them, and
/// framebuffer fetch (gl::Capabilities).
class SaturationMarks {
 public:
  /// The colour to clear the framebuffer to before begin(): no layers, T = 1.
  static constexpr std::array<GLfloat, 4> kNothing = {0, 0, 0, 1};

  static Expected<SaturationMarks> create(gl::Api& api);

  /// Clears the depths, and sets blending and the test.
  void begin(gl::Api& api) const;
  /// Marks the pixels whose T is below half a step of 8 bits.
  void mark(gl::Api& api) const;
  /// Puts the background behind: C + T·background in RGB and 1 − T in A. Blending is left off.
  void end(gl::Api& api, const glm::dvec3& background) const;

 private:
  void cover(gl::Api& api, const gl::Program& program) const;

  gl::Program mark_, background_;
  GLint color_ = -1;  // of the background
  gl::VertexArray vertex_array_;
};

}  // namespace fluxgs::render
