#include "trainer/data/layers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "trainer/data/image_io.h"

namespace fluxgs {
namespace {

using Plane = Image<std::uint8_t>;  // of one channel

constexpr std::uint8_t kOpaque = 250;
constexpr int kWhite = 128;  // from here on, a mask's pixel counts

/// The fourth channel; empty if there is none, or nothing is transparent but for rounding.
Plane alpha_of(const Image<std::uint8_t>& image) {
  if (image.channels != 4) return {};
  Plane alpha(image.width, image.height, 1);
  for (std::size_t i = 0; i < alpha.pixels.size(); ++i) alpha.pixels[i] = image.pixels[4 * i + 3];
  const bool opaque =
      std::ranges::all_of(alpha.pixels, [](std::uint8_t a) { return a >= kOpaque; });
  return opaque ? Plane() : alpha;
}

/// An RGB or RGBA image over a background by that alpha (empty: opaque), in stored sRGB values, as
/// NeRF-synthetic does.
Image<std::uint8_t> composite(const Image<std::uint8_t>& image, const Plane& alpha,
                              const glm::vec3& background) {
  int under[3];
  for (int c = 0; c < 3; ++c)
    under[c] = static_cast<int>(std::lround(std::clamp(background[c], 0.0F, 1.0F) * 255.0F));
  Image<std::uint8_t> out(image.width, image.height, 3);
  const std::size_t count = out.pixels.size() / 3, step = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < count; ++i) {
    const int a = alpha.pixels.empty() ? 255 : alpha.pixels[i];
    const std::uint8_t* in = &image.pixels[step * i];
    for (std::size_t c = 0; c < 3; ++c)
      out.pixels[3 * i + c] =
          static_cast<std::uint8_t>((in[c] * a + under[c] * (255 - a) + 127) / 255);
  }
  return out;
}

/// A mask's values as one channel.
Plane values_of(const Image<std::uint8_t>& image) {
  Plane mask(image.width, image.height, 1);
  const std::size_t step = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    const std::uint8_t* in = &image.pixels[step * i];
    const int value = std::max({in[0], in[1], in[2]});
    mask.pixels[i] = static_cast<std::uint8_t>(step == 4 ? value * in[3] / 255 : value);
  }
  const bool binary = std::ranges::all_of(mask.pixels, [](std::uint8_t v) { return v <= 1; });
  if (binary)
    for (std::uint8_t& v : mask.pixels) v = static_cast<std::uint8_t>(255 * v);
  return mask;
}

/// The orientation that undoes another one.
int inverse_of(int orientation) {
  return orientation == 6 ? 8 : orientation == 8 ? 6 : orientation;
}

/// A mask turned as its frame's photo is: it may lie as the file of the photo does, or be upright.
/// `stored`: as its file lies. Nothing if it has another shape.
Expected<Plane> turned(Plane mask, const SourceFrame& frame) {
  const ImageSize upright_size{frame.lens.width, frame.lens.height};
  const bool on_its_side = swaps_sides(frame.orientation);
  const ImageSize size{mask.width, mask.height}, swapped{mask.height, mask.width};
  if (has_shape(frame.lens, on_its_side ? swapped : size))
    return frame.orientation > 1 ? upright(mask, frame.orientation) : std::move(mask);
  if (on_its_side && has_shape(frame.lens, size)) return mask;
  // The photo stays as its file lies, but whoever made the mask saw it upright
  const auto photo = read_image_outline(frame.file);
  if (photo && swaps_sides(photo->exif.orientation) && has_shape(frame.lens, swapped))
    return upright(mask, inverse_of(photo->exif.orientation));
  return fail(frame.mask.string(), "",
              fmt::format("the mask is {}x{}, expected the shape of its photo, {}x{}", mask.width,
                          mask.height, upright_size.width, upright_size.height));
}

Plane resized(const Plane& mask, int width, int height) {
  if (mask.width == width && mask.height == height) return mask;
  Plane out(width, height, 1);
  const cv::Mat from(mask.height, mask.width, CV_8UC1,
                     const_cast<std::uint8_t*>(mask.pixels.data()));
  cv::Mat to(height, width, CV_8UC1, out.pixels.data());
  cv::resize(from, to, to.size(), 0, 0, width < mask.width ? cv::INTER_AREA : cv::INTER_LINEAR);
  return out;
}

Expected<Plane> read_mask(const SourceFrame& frame) {
  const auto image = read_image(frame.mask);
  if (!image) return std::unexpected(image.error());
  auto mask = turned(values_of(*image), frame);
  if (!mask) return mask;
  return resized(*mask, frame.lens.width, frame.lens.height);
}

/// Both together: the smaller value of each pixel. Empty planes are white.
Plane both(Plane a, const Plane& b) {
  if (a.pixels.empty()) return b;
  for (std::size_t i = 0; i < b.pixels.size(); ++i)
    a.pixels[i] = std::min(a.pixels[i], b.pixels[i]);
  return a;
}

/// Black or white; empty where all is white.
Plane decided(Plane mask) {
  for (std::uint8_t& v : mask.pixels) v = v >= kWhite ? 255 : 0;
  const bool white = std::ranges::all_of(mask.pixels, [](std::uint8_t v) { return v == 255; });
  return white ? Plane() : mask;
}

Expected<Image<std::uint8_t>> read_photo(const SourceFrame& frame) {
  auto image = read_image(frame.file);
  if (!image) return image;
  if (frame.orientation > 1) *image = upright(*image, frame.orientation);
  if (image->width == frame.lens.width && image->height == frame.lens.height) return image;
  return fail(frame.file.string(), "",
              fmt::format("the image is {}x{}, expected {}x{} as its camera says", image->width,
                          image->height, frame.lens.width, frame.lens.height));
}

}  // namespace

Expected<Layers> read_layers(const SourceFrame& frame, const LoadOptions& options) {
  const auto photo = read_photo(frame);
  if (!photo) return std::unexpected(photo.error());
  Plane transparency = alpha_of(*photo), mask;
  if (!frame.mask.empty() && options.masks != MaskUse::off) {
    auto read = read_mask(frame);
    if (!read) return std::unexpected(read.error());
    mask = std::move(*read);
  }
  Layers layers;
  if (options.masks == MaskUse::carve) transparency = both(std::move(transparency), mask);
  layers.rgb = composite(*photo, transparency, options.background);
  switch (options.masks) {
    case MaskUse::automatic:
      layers.used = decided(std::move(mask));
      layers.alpha = std::move(transparency);
      break;
    case MaskUse::ignore:
      layers.used = both(decided(std::move(mask)), transparency);
      break;
    case MaskUse::carve:
      layers.alpha = std::move(transparency);
      break;
    case MaskUse::off:
      break;
  }
  return layers;
}

}  // namespace fluxgs
