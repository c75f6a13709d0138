// A scene in images of any size, for programs that go on whatever the driver does: where memory
// is short it blends in half floats, shows harmonics of a lower degree, then fewer splats, in the
// end in fewer pixels, and when the context was lost all of it is made again.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "fluxgs/splat_degree.h"
#include "render/device.h"
#include "render/memory_estimate.h"
#include "render/render_cloud.h"

namespace fluxgs::render {

/// A frame that was drawn without the GPU.
struct SoftwareFrame {
  Image<std::uint8_t> image;  ///< RGBA, of the camera's size, A = 1 − transmittance
  std::uint32_t drawn = 0;    ///< splats that were not culled
};
/// Draws the scene's image for a camera on the CPU.
using SoftwareRenderer = std::function<SoftwareFrame(const Camera&, const RenderOptions&)>;

struct SceneViewSettings {
  RendererSettings renderer = {};
  /// Not given: the first of Device::accumulations() that there is room for.
  std::optional<Accumulation> accumulation = {};
  double scale = 1;  ///< of the image that is blended, see RenderTarget
  /// Bytes that the scene, its frames and the image may take together (memory_estimate.h). Not
  /// given: what the driver has.
  std::optional<std::size_t> memory = {};
  std::optional<std::size_t> max_splats = {};  ///< show no more than these
  /// Draws in place of the GPU, which then only shows the image: `max_splats` and `accumulation`
  /// have no effect, `memory` is that of the image.
  SoftwareRenderer software = {};
};

/// Not thread-safe; every call on the thread of the device. When a call fails and the device is
/// lost: make a new one, then open() on it.
class SceneView {
 public:
  /// The cloud is kept, as the scene must be made from it again and again.
  SceneView(std::shared_ptr<const RenderCloud> cloud, const SceneViewSettings& settings)
      : cloud_(std::move(cloud)), settings_(settings) {}

  /// Makes what is needed for images of this size. What an earlier open() made is let go of first,
  /// so its device must still be there. Fails as Device::make_renderer() does, and where memory
  /// does not even hold a pixel and a splat.
  Expected<void> open(Device& device, int width, int height);

  // Preconditions of what follows, but close(): open() was successful.

  /// Enqueues a frame. Another size of the camera than the last one means a new image and, where
  /// memory is short, another number of splats; another scale a new image only. Fails as
  /// Renderer::draw() does, when the device is lost, and when it refuses one of the first frames of
  /// a new image or scene.
  Expected<void> draw(const Camera& camera, const RenderOptions& options);

  /// Sets the scale of the frames that follow.
  void set_scale(double scale);

  /// Shows the last frame in the window, enlarged or reduced to its size.
  void show(int width, int height) const { renderer_->show(width, height); }
  /// The last frame, see Renderer::read_shown().
  Expected<Image<std::uint8_t>> read(int longest = 0) const { return renderer_->read(longest); }

  /// Lets go of all that open() made.
  void close();

  /// Number of splats in the last frame of the CPU; nothing where the GPU draws.
  std::optional<std::uint32_t> drawn_in_software() const { return drawn_in_software_; }

  /// Number of splats that there is room for: those that contribute most (splat_budget.h).
  std::size_t splats() const { return shown_.count; }
  /// The degree up to which there is room for harmonics: lower degrees go before splats do, but
  /// for the first.
  int sh_degree() const { return shown_.sh_degree; }
  bool shows_all() const { return shown_ == Amount{cloud_->size(), cloud_->sh_degree}; }
  /// True if there was no room for what was asked for and the device can do: a lower degree, fewer
  /// splats, fewer pixels or half floats.
  bool is_reduced() const;
  /// Bytes of graphics memory that are taken, by the estimate (memory_estimate.h), at the scale
  /// that takes most.
  std::size_t memory() const;

  SceneRenderer& renderer() { return *renderer_; }
  const SceneRenderer& renderer() const { return *renderer_; }
  /// The image's: the camera's size, or half as many pixels in each direction, or a quarter, …,
  /// where there is no room for it: it takes half of the memory at most, or what the splats do
  /// not need.
  ImageSize image_size() const { return renderer_->image_size(); }

 private:
  struct Size {
    int width = 0, height = 0;
    bool operator==(const Size&) const = default;
    bool is_pixel() const { return width <= 1 && height <= 1; }
    Size halved() const { return {std::max(width / 2, 1), std::max(height / 2, 1)}; }
  };
  /// How much of a scene.
  struct Amount {
    std::size_t count = 0;  ///< splats
    int sh_degree = 0;
    bool operator==(const Amount&) const = default;
  };
  std::vector<Accumulation> accumulations() const;
  TargetPlan plan(const Size& size, Accumulation accumulation) const;
  bool device_has(const Size& size) const;
  bool fits_with_all(const TargetPlan& image) const;
  bool fits_half(const TargetPlan& image) const;
  std::optional<TargetPlan> image_of(const Size& size) const;
  Expected<TargetPlan> image_for(Size size) const;
  DegreeCounts degrees_of(const Amount& amount) const;
  std::size_t splats_asked(int sh_degree) const;
  Amount asked() const;
  Amount amount_for(const TargetPlan& image) const;
  Expected<void> fit(const Size& size);
  Expected<void> fit_splats(const TargetPlan& image);
  Expected<void> make(const TargetPlan& image, const Amount& amount);
  Expected<void> make_image();
  Expected<void> upload(const Amount& amount);
  Expected<void> check_device() const;
  Expected<void> draw_in_software(const Camera& camera, const RenderOptions& options);
  Expected<void> check_first_frames();

  std::shared_ptr<const RenderCloud> cloud_;
  SceneViewSettings settings_;
  DegreeCounts degrees_{};  ///< of the cloud
  Device* device_ = nullptr;
  std::unique_ptr<SceneRenderer> renderer_;
  Size fitted_;         ///< the camera's size that there is an image for
  TargetPlan planned_;  ///< that image, for any scale
  Amount shown_;
  std::optional<std::uint32_t> drawn_in_software_;
  int unchecked_frames_ = 0;  ///< of which the device has still to say that they went well
};

}  // namespace fluxgs::render
