// The outline of JPEG and PNG files, read without decoding: the size, and whether the end is there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace fluxgs {

enum class ImageFormat { kJpeg, kPng };

struct ImageHeader {
  ImageFormat format = ImageFormat::kJpeg;
  std::int64_t width = -1, height = -1;  ///< −1: the bytes do not reach as far as the frame header
  bool complete = false;                 ///< the end marker (EOI, IEND) is in its place
};

/// Nothing if the bytes start like neither format.
std::optional<ImageHeader> parse_image_header(std::span<const std::byte> bytes);

}  // namespace fluxgs
