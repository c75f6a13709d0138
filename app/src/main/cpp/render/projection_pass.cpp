#include "render/projection_pass.h"

#include <string>
#include <vector>

#include "gl/expected_chain.h"
#include "render/vertex_source.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

constexpr std::uint32_t kThreads = 128;  // shaders/project.comp

}  // namespace

Expected<ProjectionPass> ProjectionPass::create(gl::Api& api, SplatPrecision precision) {
  const gl::ShaderSource source{GL_COMPUTE_SHADER, "project.comp", shaders::project_comp};
  ProjectionPass pass;
  pass.precision_ = precision;
  std::vector<std::string> defines;
  if (precision == SplatPrecision::half) defines.emplace_back("PROJECTED_SPLAT_HALF");
  auto compiled =
      gl::assign_or_error(gl::Program::create(api, {&source, 1}, defines), pass.program_);
  if (!compiled) return std::unexpected(compiled.error());
  return pass;
}

Expected<void> ProjectionPass::reserve(gl::Api& api, std::uint32_t count) {
  const std::size_t bytes =
      texture_padded(projected_splat_bytes(precision_) * (std::size_t{count} + 1));
  return gl::chain([&] { return projected_splats_.remake(api, bytes); },
                   [&] { return keys_.remake(api, sizeof(std::uint32_t) * count); });
}

void ProjectionPass::run(gl::Api& api, const SceneBuffers& scene) const {
  scene.geometry.bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  scene.sh.bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  projected_splats_.bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  keys_.bind_base(GL_SHADER_STORAGE_BUFFER, 3);
  program_.use();
  api.DispatchCompute(scene.constants.count / kThreads + 1, 1, 1);
  api.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace fluxgs::render
