#include "render/resolve_pass.h"

#include <array>

#include "gl/steps.h"
#include "shaders/shaders.h"

namespace fluxgs::render {

Expected<ResolvePass> ResolvePass::create(gl::Api& api) {
  const std::array<gl::ShaderSource, 2> stages = {
      {{GL_VERTEX_SHADER, "screen.vert", shaders::screen_vert},
       {GL_FRAGMENT_SHADER, "resolve.frag", shaders::resolve_frag}}};
  ResolvePass pass;
  auto compiled = gl::take(gl::Program::create(api, stages), pass.program_);
  if (!compiled) return std::unexpected(compiled.error());
  pass.vertex_array_ = gl::VertexArray(api);
  return pass;
}

void ResolvePass::run(gl::Api& api, const RenderTarget& target) const {
  if (!target.needs_resolve()) return;
  target.framebuffer().bind();
  target.blend_texture().bind(0);
  api.Viewport(0, 0, target.width(), target.height());
  program_.use();
  vertex_array_.bind();
  api.DrawArrays(GL_TRIANGLES, 0, 3);
  api.BindVertexArray(0);
}

}  // namespace fluxgs::render
