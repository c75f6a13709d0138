// Image files: JPEG and PNG in, PNG out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "fluxgs/error.h"
#include "fluxgs/image.h"

namespace fluxgs {

struct ImageSize {
  int width = 0, height = 0;  ///< pixels; 0: not known
};

/// Decode a JPEG or PNG to 8 bits a channel: RGBA if the file has transparency (straight, as
/// stored), otherwise RGB; grey becomes RGB, 16 bits are rounded to 8.
/// EXIF orientation is ignored: intrinsics in COLMAP and transforms.json refer to the pixels as
/// they are stored.
/// Errors: not a JPEG or PNG, larger than kMaxPixels (before anything is allocated), truncated
/// (even where decoders would only warn and fill up with grey), or undecodable.
Expected<Image<std::uint8_t>> read_image(const std::filesystem::path& file);

/// The size from the header of a JPEG or PNG, without decoding it.
Expected<ImageSize> read_image_size(const std::filesystem::path& file);

/// The image as a PNG of 8 bits a channel, 3 or 4 channels; floats are clamped to 0…1 and
/// rounded. The file appears complete or not at all.
Expected<void> write_png(const std::filesystem::path& file, const Image<std::uint8_t>& image);
Expected<void> write_png(const std::filesystem::path& file, const Image<float>& image);

}  // namespace fluxgs
