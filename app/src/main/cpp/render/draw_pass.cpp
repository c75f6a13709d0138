#include "render/draw_pass.h"

#include <array>
#include <string>
#include <vector>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

constexpr int kMaxPerBatch = 128;  // the work group of shaders/draw_arguments.comp
// shaders/draw_arguments.comp: DrawElementsIndirectCommand, DispatchIndirectCommand
constexpr std::size_t kDispatchOffset = 20;

// Two triangles per quad of corners 4q … 4q + 3 (bit 0: right, bit 1: bottom).
std::vector<std::uint16_t> quad_indices(int quads) {
  std::vector<std::uint16_t> indices;
  for (int q = 0; q < quads; ++q)
    for (const int corner : {0, 1, 2, 2, 1, 3})
      indices.push_back(static_cast<std::uint16_t>(4 * q + corner));
  return indices;
}

}  // namespace

Expected<DrawPass> DrawPass::create(gl::Api& api, int batch, SplatPrecision precision,
                                    bool texture_fetch) {
  if (batch < 1 || batch > kMaxPerBatch) {
    return fail("renderer", "batch", std::to_string(batch) + " quads; 1…128 were expected");
  }
  DrawPass pass;
  pass.batch_ = batch;
  pass.texture_fetch_ = texture_fetch;
  const std::string batch_define = "BATCH " + std::to_string(batch);
  std::vector<std::string> defines = {batch_define};
  if (precision == SplatPrecision::half) defines.emplace_back("PROJECTED_SPLAT_HALF");
  if (texture_fetch) defines.emplace_back("TEXTURE_FETCH");
  const gl::ShaderSource arguments{GL_COMPUTE_SHADER, "draw_arguments.comp",
                                   shaders::draw_arguments_comp};
  const std::array<gl::ShaderSource, 2> splat = {
      {{GL_VERTEX_SHADER, "splat.vert", shaders::splat_vert},
       {GL_FRAGMENT_SHADER, "splat.frag", shaders::splat_frag}}};
  const std::vector<std::uint16_t> corners = quad_indices(batch);
  const std::size_t corner_bytes = corners.size() * sizeof(corners[0]);
  auto made = gl::chain(
      [&] {
        return gl::assign_or_error(gl::Program::create(api, {&arguments, 1}, {&batch_define, 1}),
                                   pass.arguments_program_);
      },
      [&] {
        return gl::assign_or_error(gl::Program::create(api, splat, defines), pass.splat_program_);
      },
      [&]() -> Expected<void> {
        if (!texture_fetch) return {};
        return gl::assign_or_error(OrderedSplats::create(api, batch, precision), pass.ordered_);
      },
      [&] {
        return gl::assign_or_error(
            gl::Buffer::create(api, corner_bytes, corners.data(), GL_STATIC_DRAW), pass.indices_);
      },
      [&] {
        return gl::assign_or_error(gl::Buffer::create(api, kDrawArgumentsBytes), pass.arguments_);
      });
  if (!made) return std::unexpected(made.error());
  pass.vertex_array_ = gl::VertexArray(api);
  return pass;
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

void clear(gl::Api& api, const glm::dvec3& background, const RenderTarget& target) {
  target.blend_framebuffer().bind();
  // The scissor keeps tiles outside of the part from being cleared, drawn and stored
  if (target.blends_in_a_part()) {
    api.Enable(GL_SCISSOR_TEST);
    api.Scissor(0, 0, target.blend_width(), target.blend_height());
  }
  const std::array<GLfloat, 4> color = {static_cast<float>(background.r),
                                        static_cast<float>(background.g),
                                        static_cast<float>(background.b), 0.0F};
  api.ClearBufferfv(GL_COLOR, 0, color.data());
}

void DrawPass::run(gl::Api& api, const gl::Buffer& projected_splats, const sort::Sorter& sorter,
                   const glm::dvec3& background, const RenderTarget& target) const {
  write_arguments(api, sorter);
  clear(api, background, target);
  api.Viewport(0, 0, target.blend_width(), target.blend_height());
  api.Enable(GL_BLEND);
  api.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (texture_fetch_) {
    ordered_.update(api, projected_splats, sorter, arguments_, kDispatchOffset);
  } else {
    projected_splats.bind_base(GL_SHADER_STORAGE_BUFFER, 0);
    sorter.order().bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  }
  arguments_.bind(GL_DRAW_INDIRECT_BUFFER);
  splat_program_.use();
  vertex_array_.bind();
  indices_.bind(GL_ELEMENT_ARRAY_BUFFER);  // drivers of Mali forget that it belongs to the array
  api.DrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, nullptr);
  api.BindVertexArray(0);
  api.Disable(GL_BLEND);
}

}  // namespace fluxgs::render
