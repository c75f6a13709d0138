// A vertex array object without attributes: vertices are computed from gl_VertexID.
#pragma once

#include "gl/handle.h"

namespace fluxgs::gl {

class VertexArray {
 public:
  VertexArray() = default;
  explicit VertexArray(Api& api) {
    GLuint name = 0;
    api.GenVertexArrays(1, &name);
    handle_ = {api, name};
  }

  void bind() const { handle_.api().BindVertexArray(handle_.name()); }

 private:
  static void destroy(Api& api, GLuint name) { api.DeleteVertexArrays(1, &name); }
  Handle<destroy> handle_;
};

}  // namespace fluxgs::gl
