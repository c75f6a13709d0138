#include "render/compute_pipeline.h"

#include "gl/expected_chain.h"

namespace fluxgs::render {

Expected<std::unique_ptr<SplatPipeline>> ComputePipeline::create(gl::Api& api,
                                                                 const RendererSettings& settings) {
  std::unique_ptr<ComputePipeline> made(new ComputePipeline(api, settings.batch));
  auto done = gl::chain(
      [&] {
        return gl::assign_or_error(ProjectionPass::create(api, settings.splat_precision),
                                   made->projection_);
      },
      [&] { return gl::assign_or_error(DrawPass::create(api, settings), made->draw_); });
  if (!done) return std::unexpected(done.error());
  return made;
}

void ComputePipeline::unload() { scene_ = {}; }

Expected<void> ComputePipeline::load(ScenePacker& packer, std::vector<glm::vec3>* positions) {
  const std::uint32_t count = packer.constants().count;
  return gl::chain(
      [&] { return gl::assign_or_error(SceneBuffers::create(api_, packer, positions), scene_); },
      [&] { return projection_.reserve(api_, count); },
      [&] { return draw_.reserve(api_, std::uint64_t{count} + static_cast<unsigned>(batch_)); });
}

Expected<void> ComputePipeline::prepare(bool compensated) {
  return projection_.prepare(api_, compensated);
}

void ComputePipeline::project(bool compensated) {
  // The frame before may still draw from what is written now: stores of shaders wait for nobody
  // unasked (ES 3.1, 7.11.2), and a tiler reads projected_splats late
  api_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                     GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  projection_.run(api_, scene_, compensated);
}

void ComputePipeline::draw(const sort::Sorter& sorter, const glm::dvec3& background,
                           const RenderTarget& target) {
  draw_.run(api_, projection_.projected_splats(), sorter, background, target);
}

Expected<std::vector<std::uint32_t>> ComputePipeline::read_projected(std::uint32_t count) const {
  const gl::Buffer& all = projection_.projected_splats();
  const std::size_t bytes = projected_splat_bytes(projection_.precision()) * count;
  return all.read_all<std::uint32_t>(bytes / sizeof(std::uint32_t));
}

}  // namespace fluxgs::render
