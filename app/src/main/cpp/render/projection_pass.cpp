#include "render/projection_pass.h"

#include "gl/steps.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

constexpr std::uint32_t kThreads = 256;  // shaders/project.comp
constexpr GLint kHarmonicsStride = 0;

}  // namespace

Expected<ProjectionPass> ProjectionPass::create(gl::Api& api) {
  const gl::ShaderSource source{GL_COMPUTE_SHADER, "project.comp", shaders::project_comp};
  ProjectionPass pass;
  auto compiled = gl::take(gl::Program::create(api, {&source, 1}), pass.program_);
  if (!compiled) return std::unexpected(compiled.error());
  return pass;
}

Expected<void> ProjectionPass::reserve(gl::Api& api, std::uint32_t count) {
  return gl::in_turn(
      [&] { return gl::take(gl::Buffer::create(api, kRecordBytes * count), records_); },
      [&] { return gl::take(gl::Buffer::create(api, sizeof(std::uint32_t) * count), keys_); });
}

void ProjectionPass::run(gl::Api& api, const SceneBuffers& scene) const {
  scene.geometry.bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  scene.harmonics.bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  records_.bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  keys_.bind_base(GL_SHADER_STORAGE_BUFFER, 3);
  program_.use();
  api.Uniform1ui(kHarmonicsStride, scene.harmonics_stride);
  api.DispatchCompute((scene.count + kThreads - 1) / kThreads, 1, 1);
  api.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace fluxgs::render
