// The first pass of a frame: cull every splat, project those that remain.
#pragma once

#include "gl/program.h"
#include "render/scene_buffers.h"

namespace fluxgs::render {

/// Bytes of one record, shaders/record.glsl.
inline constexpr std::size_t kRecordBytes = 32;

class ProjectionPass {
 public:
  static Expected<ProjectionPass> create(gl::Api& api);

  /// Makes room for a scene of that many splats.
  Expected<void> reserve(gl::Api& api, std::uint32_t count);

  /// Enqueues the pass and the barrier behind it. The frame's uniforms must be bound at 0.
  /// Precondition: scene.count ≤ what was reserved.
  void run(gl::Api& api, const SceneBuffers& scene) const;

  /// One per splat, at its index; valid where its key is not kDropped.
  const gl::Buffer& records() const { return records_; }
  /// One per splat: the bits of its depth, or sort::kDropped.
  const gl::Buffer& keys() const { return keys_; }

 private:
  gl::Program program_;
  gl::Buffer records_, keys_;
};

}  // namespace fluxgs::render
