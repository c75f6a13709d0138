// The renderer: a splat cloud goes in, images come out. Cull and project, sort, draw, resolve.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/frame_meter.h"
#include "render/frame_uniforms.h"
#include "render/projected_splat.h"
#include "render/projection_pass.h"
#include "render/render_target.h"
#include "render/resolve_pass.h"
#include "render/scene_buffers.h"
#include "render/settings.h"
#include "render/splat_pipeline.h"
#include "sort/sorter.h"

namespace fluxgs::render {

/// Not thread-safe: every call, the destructor included, on the thread on which the context of the
/// Api is current. draw() allocates nothing, neither on the CPU nor on the GPU, and never waits for
/// the GPU (SorterKind::exact does not hold to that).
class Renderer {
 public:
  /// Compiles the shaders; `api` must outlive the renderer. Fails where the driver's limits are too
  /// small or a shader does not compile (the error holds the driver's log).
  static Expected<std::unique_ptr<Renderer>> create(gl::Api& api,
                                                    const RendererSettings& settings = {});

  /// Replaces the scene by these splats of the cloud, by all where none are given, without the
  /// harmonics beyond a degree. A cloud that is refused (see SceneBuffers) leaves the one before;
  /// when memory runs out the scene is empty. Splats with attributes that are not finite, or beyond
  /// 1e15, are kept out of every image. No copy of the scene is made on the way.
  Expected<void> upload(const RenderCloud& cloud,
                        std::optional<std::span<const std::uint32_t>> splats = {},
                        int max_sh_degree = kMaxShDegree);

  /// Enqueues a frame: the camera's image in the pixels of the target. Fails on a camera or options
  /// that make no image (view_check.h). Before the first upload() the scene is empty.
  Expected<void> draw(const Camera& camera, const RenderOptions& options,
                      const RenderTarget& target);

  /// Shows a target for a window in the window (ResolvePass::to_window()).
  void show(const RenderTarget& target, int width, int height) const {
    resolve_.to_window(api_, target, width, height);
  }
  /// The image that show() shows, as read_image() reads it of other targets. Waits for the GPU;
  /// takes little of its memory.
  Expected<Image<std::uint8_t>> read_shown(const RenderTarget& target, int longest = 0) const;

  /// Switches the measuring of later frames, see stats(). On at first; without it a frame asks
  /// the driver for nothing.
  void measure(bool on) { measured_ = on; }
  /// Counts and times of the last frame, where it is measured. Waits for the GPU.
  Expected<FrameStats> stats();
  /// Those of the newest measured frame that the GPU has finished, once; does not wait.
  Expected<std::optional<FrameStats>> finished_stats() { return meter_.poll(); }

  /// See read_pixels(). Waits for the GPU.
  Expected<Image<float>> read(const RenderTarget& target) const {
    return read_pixels(api_, target);
  }

  /// For the frames that follow. Fails on values out of their range.
  Expected<void> set_approximation(const ApproximationSettings& approximation);

  /// Makes draw() wait for the order of its own view, where that comes late
  /// (SorterKind::cpu_async). Off at first.
  void wait_for_sorts(bool wait) { waits_ = wait; }

  /// True if the last frame had the order that was last asked for. If not, the same view drawn
  /// again may be another image.
  bool order_is_current() const { return sorter_->is_current(); }

  /// Sorter::latency() of the order that was last drawn with.
  double sort_latency() const { return sorter_->latency(); }

  /// The next frame is sorted, however little the camera has moved.
  void sort_anew() { sorted_.reset(); }

  /// Number of splats of the scene that are kept out of every image.
  std::size_t undrawable() const { return undrawable_; }

  /// The settings in use: texture_fetch where the driver makes it necessary, compute and
  /// timestamps where it can.
  const RendererSettings& settings() const { return settings_; }

  // The intermediate results of the last frame, for tests and diagnostics.
  const SceneConstants& scene() const { return scene_; }
  /// The splats that the last frame projected for an image of that size; those that it does not
  /// draw have the level that says so. The first `most` of them. Waits for the GPU.
  Expected<std::vector<ProjectedSplat>> read_projected(
      int width, int height, std::uint32_t most = std::numeric_limits<std::uint32_t>::max()) const;
  /// Precondition: settings().compute.
  const ProjectionPass& projection() const { return *pipeline_->projection(); }
  const sort::Sorter& sorter() const { return *sorter_; }

 private:
  Renderer(gl::Api& api, const RendererSettings& settings) : api_(api), settings_(settings) {}
  Expected<void> create_passes();
  void limit_settings();
  Expected<void> create_pipeline();
  Expected<void> create_sorter();
  void draw_scene(const Camera& camera, const RenderOptions& options, const RenderTarget& target);
  void sort(const sort::SortView& view);
  void end_measuring(bool any);
  void stamp(int place) const;
  Expected<RenderTarget> make_strip(const glm::ivec2& size) const;

  gl::Api& api_;
  RendererSettings settings_;
  std::unique_ptr<SplatPipeline> pipeline_;
  std::unique_ptr<sort::Sorter> sorter_;
  ResolvePass resolve_;
  gl::Buffer uniforms_;
  SceneConstants scene_;
  FrameMeter meter_;
  std::optional<sort::SortView> sorted_;  // the view that the order was last asked for
  std::size_t undrawable_ = 0;
  bool waits_ = false;
  bool measured_ = true;
};

}  // namespace fluxgs::render
