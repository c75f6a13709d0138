// A graphics device as viewers see it: OpenGL's (gl_device.h) or WebGPU's (platform/web).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/image.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_degree.h"
#include "gl/quirks.h"
#include "render/frame_meter.h"
#include "render/memory_estimate.h"
#include "render/render_cloud.h"
#include "render/settings.h"

namespace fluxgs::render {

class Renderer;

/// Sizes of an image and of what its splats are blended in, px.
struct ImageSize {
  int width = 0, height = 0;
  int blend_width = 0, blend_height = 0;
};

/// A scene on a device, and the image of its last frame. Not thread-safe, and for the thread of its
/// device only. The functions that Renderer has, too, do what they do there.
class SceneRenderer {
 public:
  virtual ~SceneRenderer() = default;

  virtual const RendererSettings& settings() const = 0;
  virtual Expected<void> set_approximation(const ApproximationSettings& approximation) = 0;
  virtual void wait_for_sorts(bool wait) = 0;
  virtual void measure(bool on) = 0;

  virtual Expected<void> upload(const RenderCloud& cloud,
                                std::optional<std::span<const std::uint32_t>> splats = {},
                                int max_sh_degree = kMaxShDegree) = 0;
  virtual std::size_t undrawable() const = 0;

  /// Takes memory for another image, for a window, in place of the one before.
  virtual Expected<void> make_image(const TargetPlan& plan) = 0;
  virtual void drop_image() = 0;
  // Preconditions of what follows: an image.
  virtual ImageSize image_size() const = 0;
  /// Sets the scale, in (0, 1], of the frames that follow.
  virtual void set_scale(double scale) = 0;

  virtual Expected<void> draw(const Camera& camera, const RenderOptions& options) = 0;
  /// Takes an image that was drawn elsewhere, RGBA, of the size of what is blended.
  virtual void fill(const Image<std::uint8_t>& image) = 0;
  /// Shows the image in the window, enlarged or reduced to its size.
  virtual void show(int width, int height) const = 0;
  virtual Expected<Image<std::uint8_t>> read(int longest) const = 0;

  virtual bool order_is_current() const = 0;
  virtual void sort_anew() = 0;
  virtual double sort_latency() const = 0;
  /// Fails too where the device cannot be waited for and the frame is not finished.
  virtual Expected<FrameStats> stats() = 0;
  virtual Expected<std::optional<FrameStats>> finished_stats() = 0;

  /// The renderer of OpenGL, for diagnostics; null on other devices.
  virtual const Renderer* gl_renderer() const { return nullptr; }
};

/// Not thread-safe. Must outlive what it makes.
class Device {
 public:
  virtual ~Device() = default;

  virtual const gl::Quirks& quirks() const = 0;
  /// The ways of blending for people's eyes that there is reason to try, the most accurate first.
  virtual std::vector<Accumulation> accumulations() const = 0;
  /// The largest image, px.
  virtual int max_image_width() const = 0;
  virtual int max_image_height() const = 0;
  /// Number of splats of a scene that the limits allow, whichever they are.
  virtual std::uint64_t max_splats(const DegreeCounts& scene) const = 0;

  /// True if it is gone for good with all that it made.
  virtual bool is_lost() = 0;
  /// Makes it count as lost.
  virtual void lose() = 0;
  /// Fails with `where` and what is wrong, if it has refused something.
  virtual Expected<void> check_errors(const char* where) = 0;
  /// True if memory has run out since room_was_made().
  virtual bool is_out_of_memory() const = 0;
  virtual void room_was_made() = 0;

  virtual Expected<std::unique_ptr<SceneRenderer>> make_renderer(
      const RendererSettings& settings) = 0;
};

}  // namespace fluxgs::render
