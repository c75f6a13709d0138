#include "render/resolve_pass.h"

#include <array>
#include <string>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::render {

namespace {

/// The framebuffer that is bound is written all over: tilers would load what is covered.
void forget(gl::Api& api, GLenum attachment) {
  api.InvalidateFramebuffer(GL_FRAMEBUFFER, 1, &attachment);
}

}  // namespace

Expected<ResolvePass> ResolvePass::create(gl::Api& api) {
  const std::array<gl::ShaderSource, 2> stages = {
      {{GL_VERTEX_SHADER, "screen.vert", shaders::screen_vert},
       {GL_FRAGMENT_SHADER, "resolve.frag", shaders::resolve_frag}}};
  const std::string enlarge = "ENLARGE";
  ResolvePass pass;
  auto compiled = gl::chain(
      [&] { return gl::assign_or_error(gl::Program::create(api, stages), pass.copy_.program); },
      [&] {
        return gl::assign_or_error(gl::Program::create(api, stages, {&enlarge, 1}),
                                   pass.enlarge_.program);
      });
  if (!compiled) return std::unexpected(compiled.error());
  for (Copy* copy : {&pass.copy_, &pass.enlarge_}) {
    copy->program.set_sampler("accumulated", 0);
    copy->ratio = copy->program.uniform("ratio");
    copy->start = copy->program.uniform("start");
    copy->last = copy->program.uniform("last");
  }
  pass.vertex_array_ = gl::VertexArray(api);
  return pass;
}

void ResolvePass::run(gl::Api& api, const RenderTarget& target) const {
  if (target.needs_resolve()) to_rows(api, target, {target.width(), target.height()}, 0, target);
}

void ResolvePass::to_rows(gl::Api& api, const RenderTarget& target, const glm::ivec2& whole,
                          int first, const RenderTarget& image) const {
  image.framebuffer().bind();
  forget(api, GL_COLOR_ATTACHMENT0);
  draw(api, target, {.whole = whole, .part = {image.width(), image.height()}, .first = first});
}

void ResolvePass::to_window(gl::Api& api, const RenderTarget& target, int width, int height) const {
  api.BindFramebuffer(GL_FRAMEBUFFER, 0);
  forget(api, GL_COLOR);
  draw(api, target, {.whole = {width, height}, .part = {width, height}, .upwards = true});
}

void ResolvePass::draw(gl::Api& api, const RenderTarget& target, const Part& part) const {
  const glm::ivec2 size(target.blend_width(), target.blend_height());
  const bool same = size == part.whole;
  const glm::vec2 ratio = glm::vec2(size) / glm::vec2(part.whole);
  target.blend_texture().bind(0);
  api.Viewport(0, 0, part.part.x, part.part.y);
  const Copy& copy = same ? copy_ : enlarge_;
  copy.program.use();
  api.Uniform2f(copy.ratio, ratio.x, part.upwards ? -ratio.y : ratio.y);
  api.Uniform2f(
      copy.start, 0,
      part.upwards ? static_cast<float>(size.y) : ratio.y * static_cast<float>(part.first));
  if (!same)
    api.Uniform2f(copy.last, static_cast<float>(size.x - 1), static_cast<float>(size.y - 1));
  vertex_array_.bind();
  api.DrawArrays(GL_TRIANGLES, 0, 3);
  api.BindVertexArray(0);
}

}  // namespace fluxgs::render
