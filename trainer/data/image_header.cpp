#include "trainer/data/image_header.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

namespace fluxgs {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::uint32_t big_endian(Bytes bytes, std::size_t at, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
  return value;
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

ImageHeader parse_jpeg(Bytes bytes) {
  constexpr std::uint8_t kEndOfImage = 0xd9, kStartOfScan = 0xda;
  ImageHeader header{.format = ImageFormat::kJpeg};
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
    if (is("IEND")) {
      header.complete = header.width >= 0;
      break;
    }
    at += 12 + length;
  }
  return header;
}

}  // namespace

std::optional<ImageHeader> parse_image_header(std::span<const std::byte> raw) {
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(raw.data()), raw.size());
  constexpr std::array<std::uint8_t, 8> kPng{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (bytes.size() >= kPng.size() && std::ranges::equal(bytes.first(kPng.size()), kPng))
    return parse_png(bytes);
  if (bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff)
    return parse_jpeg(bytes);
  return std::nullopt;
}

}  // namespace fluxgs
