// Marks of pixels that layers, blended front to back, have made opaque: a depth in the tile's
// memory, which the GPU tests before it shades the fragments of later layers.
#pragma once

#include <glm/vec3.hpp>

#include "gl/program.h"
#include "gl/vertex_array.h"

namespace fluxgs::render {

/// What is drawn between begin() and end() is blended front to back, with its colour multiplied by
/// its α and at a depth in the middle: where mark() found a pixel finished it is not shaded. The
/// framebuffer that is bound holds C in RGB and the transmittance T in A meanwhile, so that T keeps
/// its digits where it is small. Marks need a target that has room for them, and framebuffer fetch
/// (gl::Capabilities).
class SaturationMarks {
 public:
  static Expected<SaturationMarks> create(gl::Api& api);

  /// Clears the framebuffer, and sets blending and the test.
  void begin(gl::Api& api) const;
  /// Marks the pixels whose T is below half a step of 8 bits.
  void mark(gl::Api& api) const;
  /// Puts the background behind: C + T·background in RGB and 1 − T in A. Blending is left off.
  void end(gl::Api& api, const glm::dvec3& background) const;

 private:
  void cover(gl::Api& api, const gl::Program& program) const;

  gl::Program mark_, background_;
  gl::VertexArray vertex_array_;
};

}  // namespace fluxgs::render
