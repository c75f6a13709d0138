// HEIC and AVIF photos, by libheif where it is installed.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "fluxgs/error.h"
#include "fluxgs/image.h"
#include "trainer/data/exif.h"
#include "trainer/data/lens.h"

namespace fluxgs {

/// True if libheif is installed.
bool has_libheif();

/// A photo as it is decoded: already turned upright and cropped as its file says.
struct HeifOutline {
  ImageSize size;
  Exif exif;  ///< orientation 1, whatever the Exif data say: the file's own transformations hold
};

/// Errors of both: libheif is not installed, or has no decoder for this file; damaged files; images
/// above kMaxPixels. `file` names the photo in them.
Expected<HeifOutline> read_heif_outline(std::span<const std::byte> bytes, const std::string& file);
Expected<Image<std::uint8_t>> decode_heif(std::span<const std::byte> bytes,
                                          const std::string& file);

}  // namespace fluxgs
