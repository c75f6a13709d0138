// The last pass over the splats: batches of quads, blended back to front, or front to back in
// slices.
#pragma once

#include <glm/vec3.hpp>

#include "gl/program.h"
#include "gl/vertex_array.h"
#include "render/ordered_splats.h"
#include "render/render_target.h"
#include "render/saturation_marks.h"
#include "render/settings.h"
#include "sort/sorter.h"

namespace fluxgs::render {

/// Bytes that shaders/draw_arguments.comp writes; those of `n` slices end where draw n begins.
constexpr std::size_t draw_arguments_bytes(int slices) {
  return 16 + 20 * static_cast<std::size_t>(slices);
}

class DrawPass {
 public:
  /// With the batch, the precision, the texture_fetch and the slices of the settings. Instances of
  /// one quad are slow on every driver tried.
  static Expected<DrawPass> create(gl::Api& api, const RendererSettings& settings);

  /// Makes room for an order of that many entries, if splats come through a texture.
  Expected<void> reserve(gl::Api& api, std::uint64_t entries);

  /// Clears the target to the background and blends the sorted splats over it. The frame's uniforms
  /// must be bound at 0; the sorter must have room for a batch of spare entries.
  void run(gl::Api& api, const gl::Buffer& projected_splats, const sort::Sorter& sorter,
           const glm::dvec3& background, const RenderTarget& target) const;

 private:
  Expected<void> create_programs(gl::Api& api, const RendererSettings& settings);
  void write_arguments(gl::Api& api, const sort::Sorter& sorter) const;
  void draw(gl::Api& api, int slice) const;

  int batch_ = 0, slices_ = 1;
  GLint slice_ = -1;
  bool texture_fetch_ = false;
  OrderedSplats ordered_;
  SaturationMarks marks_;
  gl::Program arguments_program_, splat_program_;
  gl::Buffer arguments_, indices_;
  gl::VertexArray vertex_array_;
};

/// Clears the buffer that the target's layers are blended in: the background's colour, no coverage.
/// Blending over it leaves C + T·background in RGB and 1 − T in A.
void clear(gl::Api& api, const glm::dvec3& background, const RenderTarget& target);

}  // namespace fluxgs::render
