// The outline of image files, read without decoding: the size, and whether the end is there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "trainer/data/exif.h"

namespace fluxgs {

enum class ImageFormat { kJpeg, kPng, kTiff, kBmp, kWebp, kHeif };

struct ImageHeader {
  ImageFormat format = ImageFormat::kJpeg;
  std::int64_t width = -1, height = -1;  ///< −1: the bytes do not reach as far as the frame header
  bool complete = false;                 ///< the bytes reach to the end that the header announces
  const char* refused = nullptr;         ///< reason why it is no image to use
  Exif exif = {};
};

/// HEIF and AVIF: only the format (heif.h has the rest). Nothing if the bytes start like none of
/// the formats.
std::optional<ImageHeader> parse_image_header(std::span<const std::byte> bytes);

}  // namespace fluxgs
