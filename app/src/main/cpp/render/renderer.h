// The renderer: a splat cloud goes in, pictures come out. Cull and project, sort, draw, resolve.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "gl/timestamp.h"
#include "render/draw_pass.h"
#include "render/frame_uniforms.h"
#include "render/projection_pass.h"
#include "render/render_target.h"
#include "render/resolve_pass.h"
#include "render/scene_buffers.h"
#include "sort/sorter.h"

namespace fluxgs::render {

struct RendererSettings {
  int batch = 128;          ///< quads per instance, 1…128
  int sort_digit_bits = 8;  ///< 4 or 8
  bool timestamps = false;  ///< record stage times where the driver can
};

/// GPU time of each stage in milliseconds.
struct StageTimes {
  double project = 0, sort = 0, draw = 0, resolve = 0;
};

struct FrameStats {
  std::uint32_t drawn = 0;           ///< splats that were not culled
  std::optional<StageTimes> stages;  ///< when asked for and available
};

/// Not thread-safe: every call, the destructor included, on the thread on which the context of the
/// Api is current. draw() allocates nothing, neither on the CPU nor on the GPU, and never waits for
/// the GPU.
class Renderer {
 public:
  /// Compiles the shaders; `api` must outlive the renderer. Fails where the driver's limits are too
  /// small or a shader does not compile (the error holds the driver's log).
  static Expected<std::unique_ptr<Renderer>> create(gl::Api& api,
                                                    const RendererSettings& settings = {});

  /// Replaces the scene. A cloud that is refused (see SceneBuffers) leaves the one before; when
  /// memory runs out the scene is empty. Splats with attributes that are not finite are kept out of
  /// every picture.
  Expected<void> upload(const SplatCloud& cloud);

  /// Enqueues a frame. Fails on a camera or options that make no picture, and where the camera's
  /// size is not the target's. Before the first upload() the scene is empty.
  Expected<void> draw(const Camera& camera, const RenderOptions& options,
                      const RenderTarget& target);

  /// Of the last frame. Waits for the GPU.
  Expected<FrameStats> stats() const;

  /// See read_pixels(). Waits for the GPU.
  Expected<Image<float>> read(const RenderTarget& target) const {
    return read_pixels(api_, target);
  }

  // The intermediate results of the last frame, for tests and diagnostics.
  const ProjectionPass& projection() const { return projection_; }
  const sort::Sorter& sorter() const { return *sorter_; }

 private:
  Renderer(gl::Api& api, const RendererSettings& settings) : api_(api), settings_(settings) {}
  Expected<void> create_passes();
  void set_uniforms(const Camera& camera, const RenderOptions& options);
  void stamp(int stage) const;

  gl::Api& api_;
  RendererSettings settings_;
  ProjectionPass projection_;
  std::unique_ptr<sort::Sorter> sorter_;
  DrawPass draw_;
  ResolvePass resolve_;
  gl::Buffer uniforms_;
  SceneBuffers scene_;
  std::array<gl::Timestamp, 5> stamps_;  // before, between and after the stages
  bool drawn_ = false;                   // whether there is a frame that stats() can speak of
};

}  // namespace fluxgs::render
