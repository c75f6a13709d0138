// PNG decoding that refuses damaged data and prints nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string>

#include "fluxgs/image.h"

namespace fluxgs {

/// Decodes a PNG to 8 bits of RGB, or RGBA if it has an alpha channel or a transparent color. Gamma
/// and color profiles are ignored, as in JPEG. The error is libpng's; its warnings, as about the
/// color profiles of some editors, lose no pixel and are dropped.
std::expected<Image<std::uint8_t>, std::string> decode_png(std::span<const std::byte> bytes);

}  // namespace fluxgs
