#include "render/blend_check.h"

#include <array>
#include <cmath>

#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "gl/vertex_array.h"
#include "shaders/shaders.h"

namespace fluxgs::render {

Expected<bool> half_float_blending_truncates(gl::Api& api) {
  if (!api.capabilities.half_float_targets) return false;
  constexpr int kLayers = 200;
  constexpr float kOpacity = 0.01F, kColor = 0.5F;
  const std::array<gl::ShaderSource, 2> stages = {
      {{GL_VERTEX_SHADER, "screen.vert", shaders::screen_vert},
       {GL_FRAGMENT_SHADER, "layer.frag", shaders::layer_frag}}};
  const auto program = gl::Program::create(api, stages);
  if (!program) return std::unexpected(program.error());
  const auto texture = gl::Texture::create(api, GL_RGBA16F, 1, 1);
  if (!texture) return std::unexpected(texture.error());
  const auto target = gl::Framebuffer::create(api, *texture);
  if (!target) return std::unexpected(target.error());
  const gl::VertexArray vertices(api);
  constexpr std::array<GLfloat, 4> kNothing{};
  target->bind();
  api.ClearBufferfv(GL_COLOR, 0, kNothing.data());
  api.Viewport(0, 0, 1, 1);
  api.Enable(GL_BLEND);
  api.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  program->use();
  vertices.bind();
  for (int i = 0; i < kLayers; ++i) api.DrawArrays(GL_TRIANGLES, 0, 3);
  api.Disable(GL_BLEND);
  api.BindVertexArray(0);
  std::array<GLfloat, 4> pixel{};
  api.ReadPixels(0, 0, 1, 1, GL_RGBA, GL_FLOAT, pixel.data());
  if (auto ok = gl::check_errors(api, "blending layers"); !ok) return std::unexpected(ok.error());
  const float exact = kColor * (1 - std::pow(1 - kOpacity, static_cast<float>(kLayers)));
  constexpr float kRounding = 0.004F;  // truncation costs about 0.02
  return pixel[0] < exact - kRounding;
}

}  // namespace fluxgs::render
