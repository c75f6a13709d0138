// Who stands between the renderer and the driver and knows what is allocated at the moment.
#pragma once

#include <map>
#include <numeric>
#include <utility>

#include "gl/api.h"

namespace fluxgs::test {

/// Counts the buffers, textures and framebuffers of a context, with the bytes that were asked for,
/// as long as it lives. One at a time; what was made before it is not counted. It knows the storage
/// of an object because gl::Buffer and gl::Texture allocate right after they took a name.
class LiveObjects {
 public:
  struct Count {
    std::size_t buffers = 0, textures = 0, framebuffers = 0, bytes = 0;
    bool operator==(const Count&) const = default;
  };

  explicit LiveObjects(gl::Api& api) : api_(api) {
    self_ = this;
    exchange();
  }
  LiveObjects(const LiveObjects&) = delete;
  LiveObjects& operator=(const LiveObjects&) = delete;
  ~LiveObjects() {
    exchange();
    self_ = nullptr;
  }

  Count count() const {
    const auto bytes = [](const Names& names) {
      return std::accumulate(names.begin(), names.end(), std::size_t{0},
                             [](std::size_t sum, const auto& one) { return sum + one.second; });
    };
    return {.buffers = buffers_.size(),
            .textures = textures_.size(),
            .framebuffers = framebuffers_.size(),
            .bytes = bytes(buffers_) + bytes(textures_)};
  }

 private:
  using Names = std::map<GLuint, std::size_t>;  // bytes of each

  static void made(Names& names, GLsizei count, const GLuint* made) {
    for (GLsizei i = 0; i < count; ++i) names.emplace(made[i], 0);
    self_->newest_ = made[count - 1];
  }
  static void gone(Names& names, GLsizei count, const GLuint* gone) {
    for (GLsizei i = 0; i < count; ++i) names.erase(gone[i]);
  }

  static void GL_APIENTRY gen_buffers(GLsizei count, GLuint* names) {
    self_->gen_buffers_(count, names);
    made(self_->buffers_, count, names);
  }
  static void GL_APIENTRY delete_buffers(GLsizei count, const GLuint* names) {
    gone(self_->buffers_, count, names);
    self_->delete_buffers_(count, names);
  }
  static void GL_APIENTRY gen_textures(GLsizei count, GLuint* names) {
    self_->gen_textures_(count, names);
    made(self_->textures_, count, names);
  }
  static void GL_APIENTRY delete_textures(GLsizei count, const GLuint* names) {
    gone(self_->textures_, count, names);
    self_->delete_textures_(count, names);
  }
  static void GL_APIENTRY gen_framebuffers(GLsizei count, GLuint* names) {
    self_->gen_framebuffers_(count, names);
    made(self_->framebuffers_, count, names);
  }
  static void GL_APIENTRY delete_framebuffers(GLsizei count, const GLuint* names) {
    gone(self_->framebuffers_, count, names);
    self_->delete_framebuffers_(count, names);
  }
  static void GL_APIENTRY buffer_data(GLenum target, GLsizeiptr size, const void* data,
                                      GLenum usage) {
    self_->buffers_[self_->newest_] = static_cast<std::size_t>(size);
    self_->buffer_data_(target, size, data, usage);
  }
  static void GL_APIENTRY tex_storage(GLenum target, GLsizei levels, GLenum format, GLsizei width,
                                      GLsizei height) {
    const std::size_t texel = format == GL_RGBA32F || format == GL_RGBA32UI ? 16
                              : format == GL_RGBA16F                        ? 8
                                                                            : 4;
    self_->textures_[self_->newest_] =
        texel * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    self_->tex_storage_(target, levels, format, width, height);
  }

  // The table's functions for ours, or ours for the table's.
  void exchange() {
    std::swap(api_.GenBuffers, gen_buffers_);
    std::swap(api_.DeleteBuffers, delete_buffers_);
    std::swap(api_.GenTextures, gen_textures_);
    std::swap(api_.DeleteTextures, delete_textures_);
    std::swap(api_.GenFramebuffers, gen_framebuffers_);
    std::swap(api_.DeleteFramebuffers, delete_framebuffers_);
    std::swap(api_.BufferData, buffer_data_);
    std::swap(api_.TexStorage2D, tex_storage_);
  }

  static inline LiveObjects* self_ = nullptr;
  gl::Api& api_;
  Names buffers_, textures_, framebuffers_;
  GLuint newest_ = 0;
  // Ours until the constructor has run, then the driver's.
  decltype(gl::Api::GenBuffers) gen_buffers_ = gen_buffers;
  decltype(gl::Api::DeleteBuffers) delete_buffers_ = delete_buffers;
  decltype(gl::Api::GenTextures) gen_textures_ = gen_textures;
  decltype(gl::Api::DeleteTextures) delete_textures_ = delete_textures;
  decltype(gl::Api::GenFramebuffers) gen_framebuffers_ = gen_framebuffers;
  decltype(gl::Api::DeleteFramebuffers) delete_framebuffers_ = delete_framebuffers;
  decltype(gl::Api::BufferData) buffer_data_ = buffer_data;
  decltype(gl::Api::TexStorage2D) tex_storage_ = tex_storage;
};

}  // namespace fluxgs::test
