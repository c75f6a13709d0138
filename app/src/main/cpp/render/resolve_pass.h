// Resolve pass: converts the accumulated image to the target's format, or the window's.
#pragma once

#include <glm/vec2.hpp>

#include "gl/program.h"
#include "gl/vertex_array.h"
#include "render/render_target.h"

namespace fluxgs::render {

class ResolvePass {
 public:
  static Expected<ResolvePass> create(gl::Api& api);

  /// Into the target's own image; does nothing for targets that need no resolving.
  void run(gl::Api& api, const RenderTarget& target) const;
  /// Into the window's framebuffer (number 0), enlarged or reduced to its size. Colours are copied
  /// as they are: the target's are sRGB-encoded already.
  void to_window(gl::Api& api, const RenderTarget& target, int width, int height) const;
  /// Into the rows of `image` what is in the rows from `first` on of the target's image, if that
  /// were `whole` large.
  void to_rows(gl::Api& api, const RenderTarget& target, const glm::ivec2& whole, int first,
               const RenderTarget& image) const;

 private:
  /// The part of a framebuffer that is drawn, at its origin, and where it is in the whole.
  struct Part {
    glm::ivec2 whole, part;  ///< px
    int first = 0;           ///< row
    bool upwards = false;    ///< the image's top is the last row, as in windows
  };
  void draw(gl::Api& api, const RenderTarget& target, const Part& part) const;

  /// shaders/resolve.frag and the places of its uniforms.
  struct Copy {
    gl::Program program;
    GLint ratio = -1, start = -1, last = -1;
  };
  Copy copy_, enlarge_;
  gl::VertexArray vertex_array_;
};

}  // namespace fluxgs::render
