// The first pass of a frame: cull every splat, project those that remain.
#pragma once

#include "gl/program.h"
#include "render/scene_buffers.h"
#include "render/settings.h"

namespace fluxgs::render {

class ProjectionPass {
 public:
  static Expected<ProjectionPass> create(gl::Api& api, SplatPrecision precision);

  /// Makes room for a scene of that many splats.
  Expected<void> reserve(gl::Api& api, std::uint32_t count);

  /// Enqueues the pass and the barrier behind it. The frame's uniforms must be bound at 0.
  /// Precondition: scene.count ≤ what was reserved.
  void run(gl::Api& api, const SceneBuffers& scene) const;

  /// One per splat, at its index, and an empty one behind the last. shaders/projected_splat.glsl
  const gl::Buffer& projected_splats() const { return projected_splats_; }
  /// One per splat: the key of its depth, or sort::kDropped.
  const gl::Buffer& keys() const { return keys_; }

 private:
  SplatPrecision precision_ = SplatPrecision::full;
  gl::Program program_;
  gl::Buffer projected_splats_, keys_;
};

}  // namespace fluxgs::render
