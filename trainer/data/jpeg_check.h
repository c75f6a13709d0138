// Whether a JPEG's data is sound all the way through.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace fluxgs {

/// What the decoder complains of, or nothing. Decoders go on after damage and invent the rest of
/// the image; a trainer must not learn from that. Decodes the whole image, a row at a time.
std::optional<std::string> jpeg_damage(std::span<const std::byte> bytes);

}  // namespace fluxgs
