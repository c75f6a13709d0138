// The interface of the two passes over the splats of a frame: the projection and the draw.
#pragma once

#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include "render/render_target.h"
#include "render/scene_packing.h"
#include "sort/sorter.h"

namespace fluxgs::render {

class ProjectionPass;

/// Two forms: ComputePipeline and, for drivers without compute shaders, FragmentPipeline. Not
/// thread-safe; every call with the context current. Only load() allocates.
class SplatPipeline {
 public:
  virtual ~SplatPipeline() = default;

  /// Lets go of the scene and of what its frames need.
  virtual void unload() = 0;
  /// Takes all that the packer has, which must be all of the scene, and makes room for its frames.
  /// `positions`, unless null, get where each splat lies, as add_positions() has it. Fails where
  /// memory is short.
  virtual Expected<void> load(ScenePacker& packer, std::vector<glm::vec3>* positions) = 0;

  /// Compiles the program of the screen filters that compensate opacities, before the first of
  /// them.
  virtual Expected<void> prepare(bool compensated) = 0;

  // Both enqueue. The frame's uniforms must be bound at 0. Precondition: a scene.

  /// Precondition: prepare() for that kind of filter.
  virtual void project(bool compensated) = 0;
  /// Clears the target to the background and blends the sorted splats over it. The sorter must have
  /// room for a batch of spare entries.
  virtual void draw(const sort::Sorter& sorter, const glm::dvec3& background,
                    const RenderTarget& target) = 0;

  /// The words of the first `count` splats that the last frame projected, as
  /// unpack_projected_splats() takes them. Waits for the GPU.
  virtual Expected<std::vector<std::uint32_t>> read_projected(std::uint32_t count) const = 0;

  /// The pass with the keys and the projected splats, of a pipeline of compute shaders.
  virtual const ProjectionPass* projection() const { return nullptr; }
};

}  // namespace fluxgs::render
