#include "trainer/data/image_header.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <webp/decode.h>

#include "trainer/data/stored_integer.h"

namespace fluxgs {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::uint32_t big_endian(Bytes bytes, std::size_t at, std::size_t count) {
  return stored_integer(bytes, at, count, false);
}

std::uint32_t little_endian(Bytes bytes, std::size_t at, std::size_t count) {
  return stored_integer(bytes, at, count, true);
}

/// Start of frame: every marker FFC0…FFCF but those for Huffman tables, arithmetic conditioning and
/// the reserved one (ITU T.81, table B.1).
bool is_start_of_frame(std::uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

/// The position of the next marker after entropy-coded data: FF followed by neither a stuffed zero
/// nor a restart marker (ITU T.81, B.1.1.2); the end of the bytes if there is none.
std::size_t skip_scan(Bytes bytes, std::size_t at) {
  while (at + 1 < bytes.size()) {
    const void* found = std::memchr(bytes.data() + at, 0xff, bytes.size() - at - 1);
    if (!found) return bytes.size();
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes.data());
    const std::uint8_t next = bytes[at + 1];
    if (next != 0 && next != 0xff && (next < 0xd0 || next > 0xd7)) return at;
    at += next == 0xff ? 1 : 2;
  }
  return bytes.size();
}

/// Exif data behind "Exif\0\0", as JPEG and some writers of WebP have it (CIPA DC-008, 4.5.2).
std::optional<Exif> exif_segment(Bytes segment) {
  constexpr std::array<std::uint8_t, 6> kExif{'E', 'x', 'i', 'f', 0, 0};
  if (segment.size() < kExif.size() || !std::ranges::equal(segment.first(kExif.size()), kExif))
    return std::nullopt;
  return parse_exif(segment.subspan(kExif.size()));
}

ImageHeader parse_tiff(Bytes bytes) {
  constexpr std::uint32_t kWidth = 256, kHeight = 257, kPhotometric = 262;
  constexpr std::uint64_t kCieLab = 8, kItuLab = 10;  // decoders disagree about their white
  const TiffDirectory directory(bytes);
  ImageHeader header{.format = ImageFormat::kTiff};
  const auto width = directory.first(kWidth), height = directory.first(kHeight);
  if (!width || !height) return header;
  header.width = *width;
  header.height = *height;
  header.exif = parse_exif(bytes);
  const std::uint64_t colors = directory.first(kPhotometric).value_or(0);
  if (colors >= kCieLab && colors <= kItuLab)
    header.refused = "has its colors in CIELab, expected RGB or grey";
  // Offsets and lengths of strips, or of tiles
  TiffDirectory::Values offsets = directory.find(273), lengths = directory.find(279);
  if (offsets.count == 0) {
    offsets = directory.find(324);
    lengths = directory.find(325);
  }
  header.complete = offsets.count > 0 && offsets.count == lengths.count;
  for (std::size_t i = 0; i < offsets.count && header.complete; ++i)
    header.complete =
        std::uint64_t{directory.value(offsets, i)} + directory.value(lengths, i) <= bytes.size();
  return header;
}

/// Windows bitmap: file header of 14 bytes, then BITMAPCOREHEADER or a later one.
ImageHeader parse_bmp(Bytes bytes) {
  ImageHeader header{.format = ImageFormat::kBmp};
  constexpr std::size_t kCore = 12;
  if (bytes.size() < 26) return header;
  const bool core = little_endian(bytes, 14, 4) == kCore;
  header.width = core ? little_endian(bytes, 18, 2) : little_endian(bytes, 18, 4);
  const auto height = core ? static_cast<std::int32_t>(little_endian(bytes, 20, 2))
                           : static_cast<std::int32_t>(little_endian(bytes, 22, 4));
  header.height = std::abs(std::int64_t{height});  // Negative: the top row is first
  const std::size_t depth_at = core ? 24 : 28, compression_at = 30;
  if (bytes.size() < compression_at + 4) return header;
  const std::uint64_t depth = little_endian(bytes, depth_at, 2);
  const bool packed = !core && little_endian(bytes, compression_at, 4) != 0;
  const std::uint64_t stride = (depth * static_cast<std::uint64_t>(header.width) + 31) / 32 * 4;
  const std::uint64_t end = little_endian(bytes, 10, 4) +
                            (packed ? 1 : stride * static_cast<std::uint64_t>(header.height));
  header.complete = end <= bytes.size();
  return header;
}

ImageHeader parse_webp(Bytes bytes) {
  ImageHeader header{.format = ImageFormat::kWebp};
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(bytes.data(), bytes.size(), &features) != VP8_STATUS_OK) return header;
  header.width = features.width;
  header.height = features.height;
  if (features.has_animation) header.refused = "is an animation, expected one image";
  header.complete = std::uint64_t{little_endian(bytes, 4, 4)} + 8 <= bytes.size();
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::size_t length = little_endian(bytes, at + 4, 4);
    if (length > bytes.size() - at - 8) break;
    const Bytes chunk = bytes.subspan(at + 8, length);
    if (std::memcmp(bytes.data() + at, "EXIF", 4) == 0)
      header.exif = exif_segment(chunk).value_or(parse_exif(chunk));
    at += 8 + length + length % 2;
  }
  return header;
}

ImageHeader parse_jpeg(Bytes bytes) {
  constexpr std::uint8_t kEndOfImage = 0xd9, kStartOfScan = 0xda;
  ImageHeader header{.format = ImageFormat::kJpeg};
  bool has_exif = false;
  std::size_t at = 2;
  while (at + 1 < bytes.size()) {
    if (bytes[at] != 0xff) {
      ++at;  // Padding that some writers leave; decoders skip it too.
      continue;
    }
    const std::uint8_t marker = bytes[at + 1];
    if (marker == kEndOfImage) {
      header.complete = header.width >= 0;
      return header;
    }
    const bool alone = marker == 0xff || marker <= 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    if (alone) {
      at += marker == 0xff ? 1 : 2;
      continue;
    }
    if (at + 4 > bytes.size()) return header;
    const std::size_t length = big_endian(bytes, at + 2, 2);
    if (is_start_of_frame(marker) && length >= 7 && at + 9 <= bytes.size() && header.width < 0) {
      header.height = big_endian(bytes, at + 5, 2);
      header.width = big_endian(bytes, at + 7, 2);
    }
    constexpr std::uint8_t kExifMarker = 0xe1;
    if (marker == kExifMarker && length >= 2 && at + 2 + length <= bytes.size() && !has_exif)
      if (auto exif = exif_segment(bytes.subspan(at + 4, length - 2))) {
        header.exif = std::move(*exif);
        has_exif = true;
      }
    at += 2 + length;
    if (marker == kStartOfScan) at = skip_scan(bytes, std::min(at, bytes.size()));
  }
  return header;
}

ImageHeader parse_png(Bytes bytes) {
  ImageHeader header{.format = ImageFormat::kPng};
  std::size_t at = 8;
  while (bytes.size() - at >= 12) {  // length, type, CRC
    const std::size_t length = big_endian(bytes, at, 4);
    const std::size_t left = bytes.size() - at - 12;
    const auto is = [&](const char* type) {
      return std::memcmp(bytes.data() + at + 4, type, 4) == 0;
    };
    if (is("IHDR") && length >= 8 && left >= 8) {
      header.width = big_endian(bytes, at + 8, 4);
      header.height = big_endian(bytes, at + 12, 4);
    }
    if (length > left) break;
    if (is("eXIf")) header.exif = parse_exif(bytes.subspan(at + 8, length));
    if (is("IEND")) {
      header.complete = header.width >= 0;
      break;
    }
    at += 12 + length;
  }
  return header;
}

/// The brands of HEIF and AVIF (ISO/IEC 23008-12, annex B; AV1 Image File Format, 6).
bool has_heif_brand(Bytes bytes) {
  constexpr std::string_view kBrands[] = {"heic", "heix", "heim", "heis", "hevc", "hevx",
                                          "mif1", "msf1", "avif", "avis", "miaf"};
  if (bytes.size() < 12 || std::memcmp(bytes.data() + 4, "ftyp", 4) != 0) return false;
  const std::size_t end = std::min<std::size_t>(big_endian(bytes, 0, 4), bytes.size());
  for (std::size_t at = 8; at + 4 <= end; at += 4)
    if (at != 12)  // the minor version
      for (const std::string_view brand : kBrands)
        if (std::memcmp(bytes.data() + at, brand.data(), 4) == 0) return true;
  return false;
}

}  // namespace

std::optional<ImageHeader> parse_image_header(std::span<const std::byte> raw) {
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(raw.data()), raw.size());
  const auto begins = [&](std::string_view magic, std::size_t at = 0) {
    return bytes.size() >= at + magic.size() &&
           std::memcmp(bytes.data() + at, magic.data(), magic.size()) == 0;
  };
  using namespace std::string_view_literals;
  if (has_heif_brand(bytes)) return ImageHeader{.format = ImageFormat::kHeif};
  if (begins("\x89PNG\r\n\x1a\n"sv)) return parse_png(bytes);
  if (begins("\xff\xd8\xff"sv)) return parse_jpeg(bytes);
  if (begins("II*\0"sv) || begins("MM\0*"sv)) return parse_tiff(bytes);
  if (begins("RIFF"sv) && begins("WEBP"sv, 8)) return parse_webp(bytes);
  if (begins("BM"sv)) return parse_bmp(bytes);
  return std::nullopt;
}

}  // namespace fluxgs
