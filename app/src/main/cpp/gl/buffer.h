// A buffer object of fixed size.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "gl/handle.h"

namespace fluxgs::gl {

class Buffer {
 public:
  Buffer() = default;

  /// Allocates `bytes` (at least 4 are), filled from `data` unless that is null. `target`: for
  /// indices GL_ELEMENT_ARRAY_BUFFER, with their vertex array bound, as WebGL keeps those apart
  /// from all others. Fails when the driver has not enough memory.
  static Expected<Buffer> create(Api& api, std::size_t bytes, const void* data = nullptr,
                                 GLenum usage = GL_DYNAMIC_COPY,
                                 GLenum target = GL_COPY_WRITE_BUFFER);

  /// Lets go of what this buffer holds before it becomes a new one, as there may not be room for
  /// both; it is nothing where that fails.
  Expected<void> remake(Api& api, std::size_t bytes, const void* data = nullptr,
                        GLenum usage = GL_DYNAMIC_COPY);

  GLuint name() const { return handle_.name(); }
  std::size_t size() const { return size_; }

  void bind(GLenum target) const;
  void bind_base(GLenum target, GLuint index) const;

  /// Precondition: offset + data.size() ≤ size().
  void write(std::size_t offset, std::span<const std::byte> data);

  /// Waits for the GPU and copies `out.size()` bytes from `offset`, which must lie inside.
  Expected<void> read(std::size_t offset, std::span<std::byte> out) const;

  /// read(), as `count` elements of a trivial type from the start.
  template <class T>
    requires std::is_trivially_copyable_v<T>
  Expected<std::vector<T>> read_all(std::size_t count) const {
    std::vector<T> values(count);
    auto done = read(0, std::as_writable_bytes(std::span(values)));
    if (!done) return std::unexpected(done.error());
    return values;
  }

 private:
  static void destroy(Api& api, GLuint name) { api.DeleteBuffers(1, &name); }
  Handle<destroy> handle_;
  std::size_t size_ = 0;
};

}  // namespace fluxgs::gl
