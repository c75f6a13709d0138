#include "gl/buffer.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace fluxgs::gl {

Expected<Buffer> Buffer::create(Api& api, std::size_t bytes, const void* data, GLenum usage,
                                GLenum target) {
  GLuint name = 0;
  api.GenBuffers(1, &name);
  Buffer buffer;
  buffer.handle_ = {api, name};
  buffer.size_ = std::max<std::size_t>(bytes, 4);  // Mapping or binding an empty buffer is an error
  buffer.bind(target);
  clear_errors(api);
  api.BufferData(target, static_cast<GLsizeiptr>(buffer.size_), bytes >= 4 ? data : nullptr, usage);
  const std::string where = "buffer of " + std::to_string(bytes) + " bytes";
  if (auto ok = check_errors(api, where.c_str()); !ok) return std::unexpected(ok.error());
  return buffer;
}

Expected<void> Buffer::remake(Api& api, std::size_t bytes, const void* data, GLenum usage) {
  *this = {};
  auto made = create(api, bytes, data, usage);
  if (!made) return std::unexpected(made.error());
  *this = std::move(*made);
  return {};
}

void Buffer::bind(GLenum target) const { handle_.api().BindBuffer(target, name()); }

void Buffer::bind_base(GLenum target, GLuint index) const {
  handle_.api().BindBufferBase(target, index, name());
}

void Buffer::write(std::size_t offset, std::span<const std::byte> data) {
  bind(GL_COPY_WRITE_BUFFER);
  handle_.api().BufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset),
                              static_cast<GLsizeiptr>(data.size()), data.data());
}

Expected<void> Buffer::read(std::size_t offset, std::span<std::byte> out) const {
  if (out.empty()) return {};
  Api& api = handle_.api();
  memory_barrier(api, GL_BUFFER_UPDATE_BARRIER_BIT);
  bind(GL_COPY_READ_BUFFER);
  const void* mapped = api.MapBufferRange(GL_COPY_READ_BUFFER, static_cast<GLintptr>(offset),
                                          static_cast<GLsizeiptr>(out.size()), GL_MAP_READ_BIT);
  if (!mapped) {
    clear_errors(api);
    return fail("OpenGL", "glMapBufferRange", "the driver could not map a buffer for reading");
  }
  std::memcpy(out.data(), mapped, out.size());
  api.UnmapBuffer(GL_COPY_READ_BUFFER);
  return {};
}

}  // namespace fluxgs::gl
