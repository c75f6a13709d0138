#include "render/saturation_marks.h"

#include <array>
#include <string>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::render {

Expected<SaturationMarks> SaturationMarks::create(gl::Api& api) {
  const std::array<gl::ShaderSource, 2> stages = {
      {{GL_VERTEX_SHADER, "screen.vert", shaders::screen_vert},
       {GL_FRAGMENT_SHADER, "mark.frag", shaders::mark_frag}}};
  const std::string mark = "MARK";
  SaturationMarks marks;
  auto compiled = gl::chain(
      [&] {
        return gl::assign_or_error(gl::Program::create(api, stages, {&mark, 1}), marks.mark_);
      },
      [&] { return gl::assign_or_error(gl::Program::create(api, stages), marks.background_); });
  if (!compiled) return std::unexpected(compiled.error());
  marks.color_ = marks.background_.uniform("background");
  marks.vertex_array_ = gl::VertexArray(api);
  return marks;
}

void SaturationMarks::begin(gl::Api& api) const {
  const GLfloat far = 1;
  api.DepthMask(GL_TRUE);
  api.ClearBufferfv(GL_DEPTH, 0, &far);
  api.DepthMask(GL_FALSE);
  api.Enable(GL_DEPTH_TEST);
  api.DepthFunc(GL_LESS);
  api.Enable(GL_BLEND);
  api.BlendFuncSeparate(GL_DST_ALPHA, GL_ONE, GL_ZERO, GL_ONE_MINUS_SRC_ALPHA);
}

void SaturationMarks::cover(gl::Api& api, const gl::Program& program) const {
  api.Disable(GL_BLEND);
  program.use();
  vertex_array_.bind();
  api.DrawArrays(GL_TRIANGLES, 0, 3);
  api.BindVertexArray(0);
}

void SaturationMarks::mark(gl::Api& api) const {
  // Only depths: drivers lose a pixel that a shader leaves as it was (Mesa 22's llvmpipe)
  api.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  api.DepthMask(GL_TRUE);
  cover(api, mark_);
  api.DepthMask(GL_FALSE);
  api.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  api.Enable(GL_BLEND);
}

void SaturationMarks::end(gl::Api& api, const glm::dvec3& background) const {
  api.Disable(GL_DEPTH_TEST);
  background_.use();
  api.Uniform3f(color_, static_cast<GLfloat>(background.r), static_cast<GLfloat>(background.g),
                static_cast<GLfloat>(background.b));
  cover(api, background_);
  const GLenum marks = GL_DEPTH_ATTACHMENT;  // they need not leave the tile
  api.InvalidateFramebuffer(GL_FRAMEBUFFER, 1, &marks);
}

}  // namespace fluxgs::render
