// ProjectedSplats and order for vertex stages that have no storage buffers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gl/buffer.h"
#include "gl/texture.h"

namespace fluxgs::render {

inline constexpr std::uint32_t kTextureWidth = 2048;  // shaders/splat.vert

/// The bytes of a buffer that fills whole rows of a texture of RGBA32UI, or of R32UI.
constexpr std::size_t texture_padded(std::size_t bytes) {
  constexpr std::size_t kRow = kTextureWidth * 4 * sizeof(std::uint32_t);
  return (bytes + kRow - 1) / kRow * kRow;
}

/// Two buffers as textures. ES 3.1 lets a driver have no storage blocks in the vertex stage (Mali
/// has none), and no texture buffers; the GPU copies the buffers into textures each frame.
class VertexTextures {
 public:
  /// Textures as large as buffers of these sizes, which are multiples of what texture_padded()
  /// returns. Fails where they are higher than the driver's limit.
  static Expected<VertexTextures> create(gl::Api& api, std::size_t projected_splat_bytes,
                                         std::size_t order_bytes);

  /// Enqueues the copy, after shaders that wrote the buffers, and binds the textures to units 0 and
  /// 1.
  void update(gl::Api& api, const gl::Buffer& projected_splats, const gl::Buffer& order) const;

 private:
  gl::Texture projected_splats_, order_;
  int projected_rows_ = 0, order_rows_ = 0;
};

}  // namespace fluxgs::render
