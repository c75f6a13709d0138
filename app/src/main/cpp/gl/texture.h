// A 2D texture of one level, without filtering.
#pragma once

#include "gl/handle.h"

namespace fluxgs::gl {

class Texture {
 public:
  Texture() = default;

  /// `format` is a sized internal format, e.g. GL_RGBA16F. Fails when the driver refuses.
  static Expected<Texture> create(Api& api, GLenum format, int width, int height);

  GLuint name() const { return handle_.name(); }
  /// Binds to texture unit `unit`.
  void bind(GLuint unit) const;

 private:
  static void destroy(Api& api, GLuint name) { api.DeleteTextures(1, &name); }
  Handle<destroy> handle_;
};

}  // namespace fluxgs::gl
