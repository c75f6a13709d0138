// Lossless WebP images as tables of bytes (RFC 9649), through libwebp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// Rows from the top, pixels from the left, four bytes each: red, green, blue, alpha as stored.
struct RgbaImage {
  std::size_t width = 0, height = 0;
  std::vector<std::byte> bytes;

  std::size_t pixels() const { return width * height; }
  std::uint8_t operator()(std::size_t pixel, std::size_t channel) const {
    return static_cast<std::uint8_t>(bytes[4 * pixel + channel]);
  }
};

/// Decode a still, lossless image of at least `min_pixels` and at most `max_pixels`, which are
/// checked before memory is taken. `name` and `field` appear in errors.
Expected<RgbaImage> decode_webp(std::span<const std::byte> bytes, std::size_t min_pixels,
                                std::size_t max_pixels, const std::string& name,
                                const std::string& field);

/// Encode an image without loss, the colours of transparent pixels included. The same image always
/// gives the same bytes.
Expected<std::vector<std::byte>> encode_webp(const RgbaImage& image, const std::string& name,
                                             const std::string& field);

}  // namespace fluxgs::io
