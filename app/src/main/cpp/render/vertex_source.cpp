#include "render/vertex_source.h"

#include <algorithm>
#include <string>

#include "gl/expected_chain.h"

namespace fluxgs::render {
namespace {

void copy(gl::Api& api, const gl::Buffer& from, const gl::Texture& to, GLuint unit, int rows,
          GLenum format) {
  from.bind(GL_PIXEL_UNPACK_BUFFER);
  to.bind(unit);
  api.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kTextureWidth, rows, format, GL_UNSIGNED_INT, nullptr);
  api.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

}  // namespace

Expected<VertexTextures> VertexTextures::create(gl::Api& api, std::size_t projected_splat_bytes,
                                                std::size_t order_bytes) {
  VertexTextures made;
  made.projected_rows_ = static_cast<int>(projected_splat_bytes / (16 * kTextureWidth));
  made.order_rows_ = static_cast<int>(order_bytes / (4 * kTextureWidth));
  const int rows = std::max(made.projected_rows_, made.order_rows_);
  if (rows > api.capabilities.max_texture_size) {
    return fail("scene", "size",
                "its projected_splats need textures of " + std::to_string(rows) + " rows; " +
                    api.capabilities.renderer + " offers " +
                    std::to_string(api.capabilities.max_texture_size));
  }
  auto done = gl::chain(
      [&] {
        return gl::assign_or_error(
            gl::Texture::create(api, GL_RGBA32UI, kTextureWidth, made.projected_rows_),
            made.projected_splats_);
      },
      [&] {
        return gl::assign_or_error(
            gl::Texture::create(api, GL_R32UI, kTextureWidth, made.order_rows_), made.order_);
      });
  if (!done) return std::unexpected(done.error());
  return made;
}

void VertexTextures::update(gl::Api& api, const gl::Buffer& projected_splats,
                            const gl::Buffer& order) const {
  api.MemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
  copy(api, projected_splats, projected_splats_, 0, projected_rows_, GL_RGBA_INTEGER);
  copy(api, order, order_, 1, order_rows_, GL_RED_INTEGER);
}

}  // namespace fluxgs::render
