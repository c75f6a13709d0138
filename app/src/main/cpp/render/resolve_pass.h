// Resolve pass: converts the accumulated image to the target's format.
#pragma once

#include "gl/program.h"
#include "gl/vertex_array.h"
#include "render/render_target.h"

namespace fluxgs::render {

class ResolvePass {
 public:
  static Expected<ResolvePass> create(gl::Api& api);

  /// Does nothing for targets that need no resolving.
  void run(gl::Api& api, const RenderTarget& target) const;

 private:
  gl::Program copy_, enlarge_;
  gl::VertexArray vertex_array_;
};

}  // namespace fluxgs::render
