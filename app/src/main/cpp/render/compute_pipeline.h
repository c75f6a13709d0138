// Projects in compute shaders and draws from storage buffers.
#pragma once

#include "render/draw_pass.h"
#include "render/projection_pass.h"
#include "render/splat_pipeline.h"

namespace fluxgs::render {

class ComputePipeline final : public SplatPipeline {
 public:
  /// `settings`: those of a driver that has what they ask for.
  static Expected<std::unique_ptr<SplatPipeline>> create(gl::Api& api,
                                                         const RendererSettings& settings);

  void unload() override;
  Expected<void> load(ScenePacker& packer, std::vector<glm::vec3>* positions) override;
  Expected<void> prepare(bool compensated) override;
  void project(bool compensated) override;
  void draw(const sort::Sorter& sorter, const glm::dvec3& background,
            const RenderTarget& target) override;
  Expected<std::vector<std::uint32_t>> read_projected(std::uint32_t count) const override;
  const ProjectionPass* projection() const override { return &projection_; }

 private:
  explicit ComputePipeline(gl::Api& api, int batch) : api_(api), batch_(batch) {}

  gl::Api& api_;
  int batch_ = 0;
  ProjectionPass projection_;
  DrawPass draw_;
  SceneBuffers scene_;
};

}  // namespace fluxgs::render
