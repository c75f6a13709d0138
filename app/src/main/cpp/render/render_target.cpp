#include "render/render_target.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "gl/expected_chain.h"

namespace fluxgs::render {
namespace {

GLenum internal_format(TargetFormat format) {
  return format == TargetFormat::rgba8 ? GL_RGBA8 : GL_RGBA16F;
}

Expected<void> check_size(const gl::Capabilities& driver, int width, int height) {
  const int widest = std::min(driver.max_texture_size, driver.max_viewport_width);
  const int highest = std::min(driver.max_texture_size, driver.max_viewport_height);
  if (width >= 1 && height >= 1 && width <= widest && height <= highest) return {};
  return fail("render target", "size",
              std::to_string(width) + "×" + std::to_string(height) + " pixels; 1×1 to " +
                  std::to_string(widest) + "×" + std::to_string(highest) + " are possible on " +
                  driver.renderer);
}

Expected<void> check_formats(const gl::Capabilities& driver, TargetFormat format,
                             Accumulation accumulation) {
  const bool half = format == TargetFormat::rgba16f || accumulation == Accumulation::half_float;
  if (half && !driver.half_float_targets) {
    return fail("render target", "RGBA16F",
                driver.renderer + " cannot render to it; RGBA8 is possible");
  }
  if (accumulation == Accumulation::single_float && !driver.float_targets) {
    return fail("render target", "RGBA32F", driver.renderer + " cannot blend in it");
  }
  return {};
}

Expected<void> check_scale(double scale) {
  if (scale > 0 && scale <= 1) return {};
  return fail("render target", "scale", std::to_string(scale) + "; more than 0 to 1 was expected");
}

GLenum blend_format(TargetFormat format, Accumulation accumulation) {
  switch (accumulation) {
    case Accumulation::single_float:
      return GL_RGBA32F;
    case Accumulation::half_float:
      return GL_RGBA16F;
    case Accumulation::direct:
      break;
  }
  return internal_format(format);
}

/// `depths`, if not null: takes a texture of depths that is attached as well.
Expected<void> attach(gl::Api& api, GLenum format, int width, int height, gl::Texture& texture,
                      gl::Framebuffer& framebuffer, gl::Texture* depths = nullptr) {
  auto made = gl::Texture::create(api, format, width, height);
  if (!made) return std::unexpected(made.error());
  if (depths) {
    auto marks = gl::Texture::create(api, GL_DEPTH_COMPONENT16, width, height);
    if (!marks) return std::unexpected(marks.error());
    *depths = std::move(*marks);
  }
  auto attached = gl::Framebuffer::create(api, *made, depths);
  if (!attached) return std::unexpected(attached.error());
  texture = std::move(*made);
  framebuffer = std::move(*attached);
  return {};
}

}  // namespace

int scaled_size(int size, double scale) {
  return std::max(1, static_cast<int>(std::lround(size * scale)));
}

const char* blend_name(TargetFormat format, Accumulation accumulation) {
  switch (blend_format(format, accumulation)) {
    case GL_RGBA32F:
      return "RGBA32F";
    case GL_RGBA16F:
      return "RGBA16F";
    default:
      return "RGBA8";
  }
}

Accumulation accurate_accumulation(const gl::Capabilities& driver) {
  if (driver.float_targets) return Accumulation::single_float;
  return driver.half_float_targets ? Accumulation::half_float : Accumulation::direct;
}

Accumulation default_accumulation(const gl::Api& api) {
  const Accumulation accurate = accurate_accumulation(api.capabilities);
  const bool half = !api.quirks.runs_on_cpu && !api.quirks.half_float_blending_truncates &&
                    api.capabilities.half_float_targets;
  return half && accurate == Accumulation::single_float ? Accumulation::half_float : accurate;
}

Expected<RenderTarget> RenderTarget::create(gl::Api& api, int width, int height,
                                            TargetFormat format) {
  return create(api, width, height, format, accurate_accumulation(api.capabilities));
}

Expected<RenderTarget> RenderTarget::create(gl::Api& api, int width, int height,
                                            TargetFormat format, Accumulation accumulation,
                                            double scale, bool marks) {
  const gl::Capabilities& driver = api.capabilities;
  auto possible = gl::chain([&] { return check_size(driver, width, height); },
                            [&] { return check_scale(scale); },
                            [&] { return check_formats(driver, format, accumulation); });
  if (!possible) return std::unexpected(possible.error());
  // Half-float accumulation of a half-float target is the target itself.
  if (format == TargetFormat::rgba16f && accumulation == Accumulation::half_float)
    accumulation = Accumulation::direct;

  RenderTarget target;
  target.width_ = width;
  target.height_ = height;
  target.blend_width_ = scaled_size(width, scale);
  target.blend_height_ = scaled_size(height, scale);
  target.format_ = format;
  target.accumulation_ = accumulation;
  target.has_marks_ = marks;
  gl::Texture* const depths = marks ? &target.marks_ : nullptr;
  const bool resolves = target.needs_resolve();
  auto made = attach(api, internal_format(format), width, height, target.color_,
                     target.framebuffer_, resolves ? nullptr : depths);
  if (made && resolves) {
    made = attach(api, blend_format(format, accumulation), target.blend_width_,
                  target.blend_height_, target.blend_color_, target.blend_framebuffer_, depths);
  }
  if (!made) return std::unexpected(made.error());
  return target;
}

Expected<RenderTarget> RenderTarget::create_for_window(gl::Api& api, int width, int height,
                                                       Accumulation accumulation) {
  constexpr TargetFormat kFormat = TargetFormat::rgba8;
  auto possible = gl::chain([&] { return check_size(api.capabilities, width, height); },
                            [&] { return check_formats(api.capabilities, kFormat, accumulation); });
  if (!possible) return std::unexpected(possible.error());
  RenderTarget target;
  target.width_ = target.blend_width_ = width;
  target.height_ = target.blend_height_ = height;
  target.format_ = kFormat;
  target.accumulation_ = accumulation;
  target.for_window_ = true;
  auto made = attach(api, blend_format(kFormat, accumulation), width, height, target.blend_color_,
                     target.blend_framebuffer_);
  if (!made) return std::unexpected(made.error());
  return target;
}

void RenderTarget::fill(gl::Api& api, const Image<std::uint8_t>& image) const {
  blend_texture().bind(0);
  api.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE,
                    image.pixels.data());
}

void RenderTarget::set_scale(double scale) {
  blend_width_ = scaled_size(width_, scale);
  blend_height_ = scaled_size(height_, scale);
}

const gl::Framebuffer& RenderTarget::blend_framebuffer() const {
  return blends_apart() ? blend_framebuffer_ : framebuffer_;
}

const gl::Texture& RenderTarget::blend_texture() const {
  return blends_apart() ? blend_color_ : color_;
}

Expected<Image<float>> read_pixels(gl::Api& api, const RenderTarget& target) {
  Image<float> image(target.width(), target.height(), 4);
  target.framebuffer().bind();
  api.PixelStorei(GL_PACK_ALIGNMENT, 4);
  gl::clear_errors(api);
  if (target.format() == TargetFormat::rgba8) {
    std::vector<std::uint8_t> bytes(image.pixels.size());
    api.ReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
    std::ranges::transform(bytes, image.pixels.begin(),
                           [](std::uint8_t b) { return static_cast<float>(b) / 255.0F; });
  } else {
    api.ReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_FLOAT, image.pixels.data());
  }
  if (auto ok = gl::check_errors(api, "glReadPixels"); !ok) return std::unexpected(ok.error());
  return image;
}

Expected<Image<std::uint8_t>> read_image(gl::Api& api, const RenderTarget& target, int longest) {
  struct Step {
    gl::Texture texture;
    gl::Framebuffer framebuffer;
  } step;
  const gl::Framebuffer* source = &target.framebuffer();
  int width = target.width(), height = target.height();
  while (longest > 0 && std::max(width, height) > longest) {
    const double ratio =
        std::max(0.5, static_cast<double>(longest) / static_cast<double>(std::max(width, height)));
    const int w = scaled_size(width, ratio), h = scaled_size(height, ratio);
    Step next;
    auto made = attach(api, GL_RGBA8, w, h, next.texture, next.framebuffer);
    if (!made) return std::unexpected(made.error());
    source->bind(GL_READ_FRAMEBUFFER);
    next.framebuffer.bind(GL_DRAW_FRAMEBUFFER);
    api.BlitFramebuffer(0, 0, width, height, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_LINEAR);
    step.framebuffer = std::move(next.framebuffer);  // before the texture under it
    step.texture = std::move(next.texture);
    source = &step.framebuffer;
    width = w;
    height = h;
  }
  Image<std::uint8_t> image(width, height, 4);
  source->bind();
  api.PixelStorei(GL_PACK_ALIGNMENT, 4);
  gl::clear_errors(api);
  api.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
  if (auto ok = gl::check_errors(api, "glReadPixels"); !ok) return std::unexpected(ok.error());
  return image;
}

}  // namespace fluxgs::render
