// An array in a texture, for stages and drivers without storage buffers.
#pragma once

#include <cstdint>
#include <span>

#include "gl/texture.h"

namespace fluxgs::gl {

/// Entry i is the texel (i mod 2048, i / 2048), see shaders/texel_array.glsl. The texture has whole
/// rows, one at least.
class TexelArray {
 public:
  static constexpr int kWidth = 2048;  ///< what every ES 3.0 driver offers

  TexelArray() = default;

  /// `format`: GL_RGBA32UI, GL_RG32UI or GL_R32UI. Fails where the driver has no texture of so many
  /// rows, or no memory.
  static Expected<TexelArray> create(Api& api, GLenum format, std::uint64_t entries);

  /// The bytes of an array.
  static std::uint64_t bytes(GLenum format, std::uint64_t entries);

  /// Entries that a texture of the driver's largest height has room for.
  static std::uint64_t most_entries(const Capabilities& driver) {
    return std::uint64_t{kWidth} * static_cast<std::uint64_t>(driver.max_texture_size);
  }

  /// Replaces the entries from `first` on; `data` are whole ones, which must lie inside. Binds
  /// the texture to unit 0.
  void write(Api& api, std::uint64_t first, std::span<const std::byte> data) const;

  int rows() const { return rows_; }
  const Texture& texture() const { return texture_; }
  void bind(GLuint unit) const { texture_.bind(unit); }

 private:
  GLenum format_ = 0;
  int rows_ = 0;
  Texture texture_;
};

}  // namespace fluxgs::gl
