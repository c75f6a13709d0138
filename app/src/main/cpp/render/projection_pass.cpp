#include "render/projection_pass.h"

#include <string>
#include <vector>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

constexpr std::uint32_t kThreads = 128;  // shaders/project.comp

Expected<gl::Program> compile(gl::Api& api, SplatPrecision precision, bool compensated) {
  const gl::ShaderSource source{GL_COMPUTE_SHADER, "project.comp", shaders::project_comp};
  std::vector<std::string> defines;
  if (precision == SplatPrecision::half) defines.emplace_back("PROJECTED_SPLAT_HALF");
  if (compensated) defines.emplace_back("COMPENSATED");
  return gl::Program::create(api, {&source, 1}, defines);
}

}  // namespace

Expected<ProjectionPass> ProjectionPass::create(gl::Api& api, SplatPrecision precision) {
  ProjectionPass pass;
  pass.precision_ = precision;
  auto compiled = gl::assign_or_error(compile(api, precision, false), pass.program_);
  if (!compiled) return std::unexpected(compiled.error());
  return pass;
}

Expected<void> ProjectionPass::prepare(gl::Api& api, bool compensated) {
  if (!compensated || compensated_) return {};
  return gl::assign_or_error(compile(api, precision_, true), compensated_);
}

Expected<void> ProjectionPass::reserve(gl::Api& api, std::uint32_t count) {
  const std::size_t bytes = projected_splat_bytes(precision_) * (std::size_t{count} + 1);
  return gl::chain([&] { return projected_splats_.remake(api, bytes); },
                   [&] { return keys_.remake(api, sizeof(std::uint32_t) * count); });
}

void ProjectionPass::run(gl::Api& api, const SceneBuffers& scene, bool compensated) const {
  scene.geometry.bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  scene.sh.bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  projected_splats_.bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  keys_.bind_base(GL_SHADER_STORAGE_BUFFER, 3);
  (compensated ? *compensated_ : program_).use();
  api.DispatchCompute(scene.count / kThreads + 1, 1, 1);
  api.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace fluxgs::render
