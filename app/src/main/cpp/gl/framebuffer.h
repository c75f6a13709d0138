// A framebuffer object with colour textures, and one of depths if need be.
#pragma once

#include <span>

#include "gl/handle.h"
#include "gl/texture.h"

namespace fluxgs::gl {

class Framebuffer {
 public:
  Framebuffer() = default;

  /// The textures must outlive the framebuffer. Fails when the driver cannot render to their
  /// formats.
  static Expected<Framebuffer> create(Api& api, const Texture& color,
                                      const Texture* depth = nullptr);
  /// Shaders write to output k what texture k gets; 4 textures at most.
  static Expected<Framebuffer> create(Api& api, std::span<const Texture* const> colors,
                                      const Texture* depth = nullptr);

  /// `use`: GL_FRAMEBUFFER, or only one of GL_READ_FRAMEBUFFER and GL_DRAW_FRAMEBUFFER.
  void bind(GLenum use = GL_FRAMEBUFFER) const {
    handle_.api().BindFramebuffer(use, handle_.name());
  }

 private:
  static void destroy(Api& api, GLuint name) { api.DeleteFramebuffers(1, &name); }
  Handle<destroy> handle_;
};

}  // namespace fluxgs::gl
