// Projects in fragment shaders, or where those are not exact enough in vertex shaders, and draws
// from textures: for drivers without compute shaders and storage buffers, which are those of OpenGL
// ES 3.0, and of browsers.
#pragma once

#include <optional>

#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texel_array.h"
#include "gl/vertex_array.h"
#include "render/settings.h"
#include "render/splat_pipeline.h"

namespace fluxgs::render {

/// The scene and the projected splats are texel arrays; a fragment, or a point, projects a splat.
/// The sorter must be one with an order_texture().
class FragmentPipeline final : public SplatPipeline {
 public:
  /// With the batch, the precision and project_in_vertices of the settings.
  static Expected<std::unique_ptr<SplatPipeline>> create(gl::Api& api,
                                                         const RendererSettings& settings);

  /// Bytes of a scene, and of its projected splats.
  static std::uint64_t scene_bytes(const DegreeCounts& splats);
  static std::uint64_t projected_bytes(std::uint64_t count, SplatPrecision precision);
  /// Number of splats of a scene that the driver's limits allow, whichever they are.
  static std::uint64_t max_splats(const gl::Capabilities& driver, const DegreeCounts& scene);

  void unload() override;
  Expected<void> load(ScenePacker& packer, std::vector<glm::vec3>* positions) override;
  Expected<void> prepare(bool compensated) override;
  void project(bool compensated) override;
  void draw(const sort::Sorter& sorter, const glm::dvec3& background,
            const RenderTarget& target) override;
  Expected<std::vector<std::uint32_t>> read_projected(std::uint32_t count) const override;

 private:
  FragmentPipeline(gl::Api& api, const RendererSettings& settings)
      : api_(api),
        precision_(settings.splat_precision),
        batch_(settings.batch),
        in_vertices_(settings.project_in_vertices) {}
  /// A program that projects, and the place of its uniform `rows`.
  struct Projection {
    gl::Program program;
    GLint rows = -1;
  };
  Expected<Projection> compile_projection(bool compensated) const;
  Expected<gl::Program> compile_draw() const;
  Expected<void> load_scene(ScenePacker& packer, std::vector<glm::vec3>* positions);
  Expected<void> make_room(std::uint64_t count);
  bool full() const { return precision_ == SplatPrecision::full; }

  gl::Api& api_;
  SplatPrecision precision_;
  int batch_;
  bool in_vertices_;
  Projection projection_;
  std::optional<Projection> compensated_;
  gl::Program draw_;
  std::uint32_t count_ = 0;  // splats of the scene
  GLint drawn_ = -1;
  gl::Buffer indices_;
  gl::VertexArray vertex_array_;
  gl::TexelArray geometry_, coefficients_;  // of the scene
  gl::TexelArray first_, second_;           // words of each projected splat; of half ones the first
  gl::Framebuffer projected_;
};

}  // namespace fluxgs::render
