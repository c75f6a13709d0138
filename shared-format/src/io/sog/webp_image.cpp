#include "io/sog/webp_image.h"

#include <cstring>

#include <fmt/format.h>
#include <webp/decode.h>
#include <webp/encode.h>

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

Expected<std::vector<std::byte>> encode_webp(const RgbaImage& image, const std::string& name,
                                             const std::string& field) {
  constexpr int kEffort = 4;  // of 0…9: more takes several times as long for a percent of the size
  WebPConfig config;
  WebPPicture picture;
  if (WebPConfigInit(&config) == 0 || WebPConfigLosslessPreset(&config, kEffort) == 0 ||
      WebPPictureInit(&picture) == 0)
    return fail(name, field, "libwebp is of another version than the one compiled against");
  config.exact = 1;
  picture.use_argb = 1;
  picture.width = static_cast<int>(image.width);
  picture.height = static_cast<int>(image.height);
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  const bool done = WebPPictureImportRGBA(&picture, data_of(image.bytes), 4 * picture.width) != 0 &&
                    WebPEncode(&config, &picture) != 0;
  const int error = picture.error_code;
  WebPPictureFree(&picture);
  auto bytes = done ? allocate_bytes(writer.size, name) : Expected<std::vector<std::byte>>();
  if (done && bytes) std::memcpy(bytes->data(), writer.mem, writer.size);
  WebPMemoryWriterClear(&writer);
  if (!done) return fail(name, field, fmt::format("libwebp could not encode it: error {}", error));
  return bytes;
}

}  // namespace fluxgs::io
