// Image files: JPEG, PNG, WebP, TIFF, BMP, and HEIC and AVIF (by libheif) in, PNG and JPEG out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/image.h"
#include "trainer/data/exif.h"
#include "trainer/data/lens.h"

namespace fluxgs {

/// An image file as its header describes it.
struct ImageOutline {
  ImageSize size;  ///< as stored
  Exif exif;       ///< its orientation says how to turn the stored image
};

/// True for orientations that turn an image on its side.
inline bool swaps_sides(int orientation) { return orientation >= 5; }

/// Decode an image file to 8 bits a channel: RGBA if the file has transparency (straight, as
/// stored), otherwise RGB; grey becomes RGB, 16 bits are rounded to 8.
/// EXIF orientation is ignored (HEIC and AVIF come upright): most intrinsics refer to the pixels as
/// they are stored (see fit_images.h). Errors: none of these formats, larger than kMaxPixels
/// (before anything is allocated), truncated (even where decoders would only warn and fill up with
/// grey), or undecodable.
Expected<Image<std::uint8_t>> read_image(const std::filesystem::path& file);

/// The size and Exif data from the header of an image file, without decoding it.
Expected<ImageOutline> read_image_outline(const std::filesystem::path& file);

/// The image turned upright from how an EXIF orientation says that it is stored.
Image<std::uint8_t> upright(const Image<std::uint8_t>& image, int orientation);

/// The image as a PNG of 8 bits a channel, 3 or 4 channels; floats are clamped to 0…1 and
/// rounded. The file appears complete or not at all.
Expected<void> write_png(const std::filesystem::path& file, const Image<std::uint8_t>& image);
Expected<void> write_png(const std::filesystem::path& file, const Image<float>& image);

/// The image as a JPEG, 3 channels; `quality` 1…100. `name` appears in errors.
Expected<std::vector<std::byte>> encode_jpeg(const std::string& name, const Image<float>& image,
                                             int quality);

}  // namespace fluxgs
