#include "io/sog/webp_image.h"

#include <fmt/format.h>
#include <webp/decode.h>

#include "cloud/cloud_memory.h"

namespace fluxgs::io {
namespace {

constexpr int kLossless = 2;  // WebPBitstreamFeatures::format

const std::uint8_t* data_of(std::span<const std::byte> bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

}  // namespace

Expected<RgbaImage> decode_webp(std::span<const std::byte> bytes, std::size_t min_pixels,
                                std::size_t max_pixels, const std::string& name,
                                const std::string& field) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data_of(bytes), bytes.size(), &features) != VP8_STATUS_OK) {
    return fail(name, field, "is not a whole WebP image");
  }
  if (features.has_animation != 0) return fail(name, field, "is animated; expected a still image");
  if (features.format != kLossless) {
    return fail(name, field, "is lossy; expected lossless WebP, its bytes are numbers");
  }
  RgbaImage image;
  image.width = static_cast<std::size_t>(features.width);
  image.height = static_cast<std::size_t>(features.height);
  if (image.pixels() < min_pixels || image.pixels() > max_pixels) {
    return fail(name, field,
                fmt::format("is {}x{}; expected {} to {} pixels", image.width, image.height,
                            min_pixels, max_pixels));
  }
  auto pixels = allocate_bytes(4 * image.pixels(), name);
  if (!pixels) return std::unexpected(pixels.error());
  image.bytes = std::move(*pixels);
  if (WebPDecodeRGBAInto(data_of(bytes), bytes.size(),
                         reinterpret_cast<std::uint8_t*>(image.bytes.data()), image.bytes.size(),
                         4 * features.width) == nullptr) {
    return fail(name, field, "is a damaged WebP image, or memory ran out");
  }
  return image;
}

}  // namespace fluxgs::io
