#include "render/draw_pass.h"

#include <array>
#include <string>
#include <vector>

#include "gl/expected_chain.h"
#include "render/quad_indices.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

constexpr std::size_t kDispatchOffset = 0;  // shaders/draw_arguments.comp

}  // namespace

Expected<DrawPass> DrawPass::create(gl::Api& api, const RendererSettings& settings) {
  DrawPass pass;
  pass.batch_ = settings.batch;
  pass.slices_ = settings.slices;
  pass.texture_fetch_ = settings.texture_fetch;
  auto made = gl::chain(
      [&] { return pass.create_programs(api, settings); },
      [&]() -> Expected<void> {
        if (!settings.texture_fetch) return {};
        return gl::assign_or_error(
            OrderedSplats::create(api, settings.batch, settings.splat_precision), pass.ordered_);
      },
      [&]() -> Expected<void> {
        if (settings.slices == 1) return {};
        return gl::assign_or_error(SaturationMarks::create(api), pass.marks_);
      },
      [&] { return gl::assign_or_error(create_quad_indices(api, settings.batch), pass.indices_); },
      [&] {
        return gl::assign_or_error(gl::Buffer::create(api, draw_arguments_bytes(settings.slices)),
                                   pass.arguments_);
      });
  if (!made) return std::unexpected(made.error());
  if (settings.texture_fetch) pass.splat_program_.set_sampler("ordered", 0);
  if (settings.slices > 1) {
    pass.splat_program_.use();
    pass.slice_ = pass.splat_program_.uniform("slice");
    api.Uniform1ui(pass.splat_program_.uniform("slices"), static_cast<GLuint>(settings.slices));
  }
  pass.vertex_array_ = gl::VertexArray(api);
  return pass;
}

Expected<void> DrawPass::create_programs(gl::Api& api, const RendererSettings& settings) {
  const std::string batch_define = "BATCH " + std::to_string(settings.batch);
  std::vector<std::string> defines = {batch_define};
  if (settings.splat_precision == SplatPrecision::half)
    defines.emplace_back("PROJECTED_SPLAT_HALF");
  if (settings.texture_fetch) defines.emplace_back("TEXTURE_FETCH");
  if (settings.slices > 1) defines.emplace_back("FRONT_TO_BACK");
  const gl::ShaderSource arguments{GL_COMPUTE_SHADER, "draw_arguments.comp",
                                   shaders::draw_arguments_comp};
  const std::array<gl::ShaderSource, 2> splat = {
      {{GL_VERTEX_SHADER, "splat.vert", shaders::splat_vert},
       {GL_FRAGMENT_SHADER, "splat.frag", shaders::splat_frag}}};
  return gl::chain(
      [&] {
        return gl::assign_or_error(gl::Program::create(api, {&arguments, 1}, {&batch_define, 1}),
                                   arguments_program_);
      },
      [&] {
        return gl::assign_or_error(gl::Program::create(api, splat, defines), splat_program_);
      });
}

void DrawPass::write_arguments(gl::Api& api, const sort::Sorter& sorter) const {
  sorter.count().bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  sorter.order().bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  arguments_.bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  arguments_program_.use();
  api.DispatchCompute(1, 1, 1);
  api.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

Expected<void> DrawPass::reserve(gl::Api& api, std::uint64_t entries) {
  return texture_fetch_ ? ordered_.reserve(api, entries) : Expected<void>();
}

namespace {

void clear_to(gl::Api& api, const std::array<GLfloat, 4>& color, const RenderTarget& target) {
  target.blend_framebuffer().bind();
  // The scissor keeps tiles outside of the part from being cleared, drawn and stored
  if (target.blends_in_a_part()) {
    api.Enable(GL_SCISSOR_TEST);
    api.Scissor(0, 0, target.blend_width(), target.blend_height());
  }
  api.ClearBufferfv(GL_COLOR, 0, color.data());
}

}  // namespace

void clear(gl::Api& api, const glm::dvec3& background, const RenderTarget& target) {
  const glm::vec3 color(background);
  clear_to(api, {color.r, color.g, color.b, 0}, target);
}

void DrawPass::draw(gl::Api& api, int slice) const {
  splat_program_.use();
  if (slices_ > 1) api.Uniform1ui(slice_, static_cast<GLuint>(slice));
  vertex_array_.bind();
  indices_.bind(GL_ELEMENT_ARRAY_BUFFER);  // drivers of Mali forget that it belongs to the array
  // OpenGL takes the offset as a pointer
  // NOLINTNEXTLINE(performance-no-int-to-ptr)
  const auto* const offset = reinterpret_cast<const void*>(draw_arguments_bytes(slice));
  api.DrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, offset);
  api.BindVertexArray(0);
}

void DrawPass::run(gl::Api& api, const gl::Buffer& projected_splats, const sort::Sorter& sorter,
                   const glm::dvec3& background, const RenderTarget& target) const {
  write_arguments(api, sorter);
  if (slices_ == 1) {
    clear(api, background, target);
  } else {
    clear_to(api, SaturationMarks::kNothing, target);
  }
  api.Viewport(0, 0, target.blend_width(), target.blend_height());
  if (texture_fetch_) {
    ordered_.update(api, projected_splats, sorter, arguments_, kDispatchOffset);
  } else {
    projected_splats.bind_base(GL_SHADER_STORAGE_BUFFER, 0);
    sorter.order().bind_base(GL_SHADER_STORAGE_BUFFER, 1);
    if (slices_ > 1) sorter.count().bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  }
  arguments_.bind(GL_DRAW_INDIRECT_BUFFER);
  api.Enable(GL_BLEND);
  if (slices_ == 1) {
    api.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    draw(api, 0);
  } else {
    marks_.begin(api);
    for (int slice = 0; slice < slices_; ++slice) {
      if (slice > 0) marks_.mark(api);
      draw(api, slice);
    }
    marks_.end(api, background);
  }
  api.Disable(GL_BLEND);
}

}  // namespace fluxgs::render
