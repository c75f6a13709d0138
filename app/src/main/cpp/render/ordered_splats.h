// Projected splats in drawing order, for vertex stages that have no storage buffers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texel_array.h"
#include "render/settings.h"
#include "sort/sorter.h"

namespace fluxgs::render {

/// The bytes of the texture that holds so many projected splats: whole rows.
std::size_t ordered_splat_bytes(std::uint64_t count, SplatPrecision precision);

/// A texture with the projected splats of a frame, one behind the other as they are drawn. ES 3.1
/// lets a driver have no storage blocks in the vertex stage (Mali has none), and no texture
/// buffers. A compute pass gathers the splats, so that the vertex stage, which a tiler runs twice
/// and more, reads them in sequence.
class OrderedSplats {
 public:
  /// `batch`: quads per instance.
  static Expected<OrderedSplats> create(gl::Api& api, int batch, SplatPrecision precision);

  /// Makes room for that many entries. Fails where the texture is higher than the driver's limit.
  Expected<void> reserve(gl::Api& api, std::uint64_t entries);

  /// Enqueues the copy, after the shaders that wrote the splats and the order, and binds the
  /// texture to unit 0. `arguments` holds a DispatchIndirectCommand at `dispatch_offset`
  /// (shaders/draw_arguments.comp).
  void update(gl::Api& api, const gl::Buffer& projected_splats, const sort::Sorter& sorter,
              const gl::Buffer& arguments, std::size_t dispatch_offset) const;

 private:
  SplatPrecision precision_ = SplatPrecision::full;
  gl::Program program_;
  gl::TexelArray texels_;
};

}  // namespace fluxgs::render
