#include "gl/texel_array.h"

#include <algorithm>
#include <string>

namespace fluxgs::gl {
namespace {

constexpr std::uint64_t kRow = TexelArray::kWidth;

struct Layout {
  GLenum channels;
  std::size_t bytes;
};

/// The layout of the entries in the CPU's memory.
Layout layout_of(GLenum format) {
  switch (format) {
    case GL_RGBA32UI:
      return {GL_RGBA_INTEGER, 16};
    case GL_RG32UI:
      return {GL_RG_INTEGER, 8};
    default:
      return {GL_RED_INTEGER, 4};
  }
}

std::uint64_t rows_of(std::uint64_t entries) {
  return std::max<std::uint64_t>((entries + kRow - 1) / kRow, 1);
}

}  // namespace

std::uint64_t TexelArray::bytes(GLenum format, std::uint64_t entries) {
  return rows_of(entries) * kRow * layout_of(format).bytes;
}

Expected<TexelArray> TexelArray::create(Api& api, GLenum format, std::uint64_t entries) {
  const std::uint64_t rows = rows_of(entries);
  const int most = api.capabilities.max_texture_size;
  if (rows > static_cast<std::uint64_t>(most)) {
    return fail("scene", "size",
                "it needs a texture of " + std::to_string(rows) + " rows; " +
                    api.capabilities.renderer + " offers " + std::to_string(most));
  }
  TexelArray made;
  made.format_ = format;
  made.rows_ = static_cast<int>(rows);
  auto texture = Texture::create(api, format, kWidth, made.rows_);
  if (!texture) return std::unexpected(texture.error());
  made.texture_ = std::move(*texture);
  return made;
}

void TexelArray::write(Api& api, std::uint64_t first, std::span<const std::byte> data) const {
  const Layout layout = layout_of(format_);
  bind(0);
  while (!data.empty()) {
    // The rest of a row, or as many whole rows as there are
    const std::uint64_t column = first % kRow, count = data.size() / layout.bytes;
    const bool whole = column == 0 && count >= kRow;
    const std::uint64_t width = whole ? kRow : std::min(kRow - column, count);
    const std::uint64_t height = whole ? count / kRow : 1;
    api.TexSubImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(column),
                      static_cast<GLint>(first / kRow), static_cast<GLsizei>(width),
                      static_cast<GLsizei>(height), layout.channels, GL_UNSIGNED_INT, data.data());
    first += width * height;
    data = data.subspan(width * height * layout.bytes);
  }
}

}  // namespace fluxgs::gl
