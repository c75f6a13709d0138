// JPEG decoding that refuses damaged data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string>

#include "fluxgs/image.h"

namespace fluxgs {

/// Decodes a JPEG to RGB; grey becomes RGB, CMYK is converted without a color profile. EXIF
/// orientation is ignored. The error is the decoder's complaint: other decoders go on after damage
/// and invent the rest of the image, from which a trainer must not learn.
std::expected<Image<std::uint8_t>, std::string> decode_jpeg(std::span<const std::byte> bytes);

}  // namespace fluxgs
