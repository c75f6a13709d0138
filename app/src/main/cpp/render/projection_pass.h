// The first pass of a frame: cull every splat, project those that remain.
#pragma once

#include <optional>

#include "gl/program.h"
#include "render/scene_buffers.h"
#include "render/settings.h"

namespace fluxgs::render {

class ProjectionPass {
 public:
  static Expected<ProjectionPass> create(gl::Api& api, SplatPrecision precision);

  /// Makes room for a scene of that many splats.
  Expected<void> reserve(gl::Api& api, std::uint32_t count);

  /// Compiles the program of the screen filters that compensate opacities, before the first of
  /// them.
  Expected<void> prepare(gl::Api& api, bool compensated);

  /// Enqueues the pass and the barrier behind it. The frame's uniforms must be bound at 0.
  /// Preconditions: scene.count ≤ what was reserved; prepare() for that kind of filter.
  void run(gl::Api& api, const SceneBuffers& scene, bool compensated) const;

  SplatPrecision precision() const { return precision_; }
  /// One per splat, at its index, and an empty one behind the last. shaders/projected_splat.glsl
  const gl::Buffer& projected_splats() const { return projected_splats_; }
  /// One per splat: the key of its depth, or sort::kDropped.
  const gl::Buffer& keys() const { return keys_; }

 private:
  SplatPrecision precision_ = SplatPrecision::full;
  gl::Program program_;
  std::optional<gl::Program> compensated_;
  gl::Buffer projected_splats_, keys_;
};

}  // namespace fluxgs::render
