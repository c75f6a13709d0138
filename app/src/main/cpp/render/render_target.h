// Off-screen images that the renderer draws into.
#pragma once

#include <cstdint>

#include "fluxgs/image.h"
#include "gl/framebuffer.h"
#include "gl/texture.h"

namespace fluxgs::render {

enum class TargetFormat { rgba8, rgba16f };

/// Buffer in which the layers are blended before the target holds the image.
enum class Accumulation {
  direct,        ///< in the target itself: the least memory traffic, rounds at every layer
  half_float,    ///< in RGBA16F
  single_float,  ///< in RGBA32F (needs Capabilities::float_targets)
};

/// The accumulation that keeps rounding below what the format can show, or the nearest to it that
/// the driver has.
Accumulation accurate_accumulation(const gl::Capabilities& capabilities);

/// The one to look at a scene with: half floats on a GPU, which blends pixels of 128 bits several
/// times slower; accurate_accumulation() where the processor plays the GPU and gains nothing, and
/// where half floats are truncated.
Accumulation default_accumulation(const gl::Api& api);

/// Pixels of a side of an image at that scale.
int scaled_size(int size, double scale);

/// Name of the format that layers are blended in: "RGBA8", "RGBA16F", "RGBA32F".
const char* blend_name(TargetFormat format, Accumulation accumulation);

/// A colour texture with premultiplied RGBA: RGB over the background, A = 1 − transmittance.
/// Row 0 of its memory is the top of the image. GL objects: see gl::Handle about lifetimes.
class RenderTarget {
 public:
  /// `scale`, in (0, 1]: the layers are blended in so much smaller an image, which is then
  /// enlarged. Fails on sizes below 1×1 or above the driver's limit and on formats it cannot render
  /// to. `marks`: with depths beside what is blended, in which SaturationMarks marks pixels.
  static Expected<RenderTarget> create(gl::Api& api, int width, int height, TargetFormat format,
                                       Accumulation accumulation, double scale = 1,
                                       bool marks = false);
  /// With accurate_accumulation().
  static Expected<RenderTarget> create(gl::Api& api, int width, int height, TargetFormat format);
  /// For images of a window, which the resolve pass draws there: without an image of its own, and
  /// with room for every scale. Of scale 1 at first.
  static Expected<RenderTarget> create_for_window(gl::Api& api, int width, int height,
                                                  Accumulation accumulation);

  /// Takes an image of what the splats are blended into, RGBA. Precondition: its size is that, and
  /// the format is rgba8 without another accumulation.
  void fill(gl::Api& api, const Image<std::uint8_t>& image) const;

  /// Sets the scale, in (0, 1], of the frames that follow; for targets of a window only.
  void set_scale(double scale);

  /// Rows of a window's image that are read at once.
  static constexpr int kRowsRead = 256;

  int width() const { return width_; }
  int height() const { return height_; }
  TargetFormat format() const { return format_; }
  Accumulation accumulation() const { return accumulation_; }
  bool has_marks() const { return has_marks_; }

  /// The size of what the splats are blended into.
  int blend_width() const { return blend_width_; }
  int blend_height() const { return blend_height_; }
  /// Framebuffer that the splats are blended into: the target itself for Accumulation::direct at
  /// scale 1.
  const gl::Framebuffer& blend_framebuffer() const;
  const gl::Texture& blend_texture() const;
  /// True if the splats are blended into a part of it, at its origin.
  bool blends_in_a_part() const { return for_window_ && enlarges(); }
  bool needs_resolve() const {
    return !for_window_ && (accumulation_ != Accumulation::direct || enlarges());
  }
  bool enlarges() const { return blend_width_ != width_ || blend_height_ != height_; }
  /// The framebuffer of the image; a target for a window has none.
  const gl::Framebuffer& framebuffer() const { return framebuffer_; }

 private:
  /// True if there is a texture of its own for the blending.
  bool blends_apart() const { return for_window_ || needs_resolve(); }

  int width_ = 0, height_ = 0;
  int blend_width_ = 0, blend_height_ = 0;
  TargetFormat format_ = TargetFormat::rgba8;
  Accumulation accumulation_ = Accumulation::direct;
  bool for_window_ = false, has_marks_ = false;
  // The framebuffers come last: they must go before their textures.
  gl::Texture color_, blend_color_, marks_;
  gl::Framebuffer framebuffer_, blend_framebuffer_;
};

/// Waits for the GPU and copies the image: RGBA, top row first, 0…1 for rgba8.
Expected<Image<float>> read_pixels(gl::Api& api, const RenderTarget& target);

/// The same in 8 bits, for people, of an rgba8 target; reduced by the GPU, in steps of a half,
/// until its longer side is `longest` pixels or it was no longer than that. 0: as large as it is.
Expected<Image<std::uint8_t>> read_image(gl::Api& api, const RenderTarget& target, int longest = 0);

}  // namespace fluxgs::render
