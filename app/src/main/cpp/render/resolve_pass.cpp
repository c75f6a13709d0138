#include "render/resolve_pass.h"

#include <array>
#include <string>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::render {

namespace {

constexpr GLint kRatio = 0;  // shaders/resolve.frag

}  // namespace

Expected<ResolvePass> ResolvePass::create(gl::Api& api) {
  const std::array<gl::ShaderSource, 2> stages = {
      {{GL_VERTEX_SHADER, "screen.vert", shaders::screen_vert},
       {GL_FRAGMENT_SHADER, "resolve.frag", shaders::resolve_frag}}};
  const std::string enlarge = "ENLARGE";
  ResolvePass pass;
  auto compiled = gl::chain(
      [&] { return gl::assign_or_error(gl::Program::create(api, stages), pass.copy_); },
      [&] {
        return gl::assign_or_error(gl::Program::create(api, stages, {&enlarge, 1}), pass.enlarge_);
      });
  if (!compiled) return std::unexpected(compiled.error());
  pass.vertex_array_ = gl::VertexArray(api);
  return pass;
}

void ResolvePass::run(gl::Api& api, const RenderTarget& target) const {
  if (!target.needs_resolve()) return;
  target.framebuffer().bind();
  constexpr GLenum kAll = GL_COLOR_ATTACHMENT0;
  api.InvalidateFramebuffer(GL_FRAMEBUFFER, 1, &kAll);  // or tilers would load what is covered
  target.blend_texture().bind(0);
  api.Viewport(0, 0, target.width(), target.height());
  if (target.enlarges()) {
    enlarge_.use();
    api.Uniform2f(kRatio,
                  static_cast<float>(target.blend_width()) / static_cast<float>(target.width()),
                  static_cast<float>(target.blend_height()) / static_cast<float>(target.height()));
  } else {
    copy_.use();
  }
  vertex_array_.bind();
  api.DrawArrays(GL_TRIANGLES, 0, 3);
  api.BindVertexArray(0);
}

}  // namespace fluxgs::render
