// gzip and zstd as SPZ uses them, into buffers of a size that is known beforehand.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// Result of inflating gzip into a buffer.
struct Inflated {
  std::size_t written = 0;   ///< bytes of the buffer that were filled
  std::size_t consumed = 0;  ///< bytes of the input that were used
  bool ended = false;        ///< the stream ended there and its checksum is right
  bool damaged = false;      ///< the input is not gzip or is inconsistent
};

/// Inflate the first bytes of gzip, of which no more than its first 4 KiB are looked at, so that a
/// long file name in it costs no time.
Inflated inflate_gzip_start(std::span<const std::byte> input, std::span<std::byte> out);

/// Inflate until the stream, the input or the buffer ends.
Inflated inflate_gzip(std::span<const std::byte> input, std::span<std::byte> out);

/// The reason why fewer bytes came out than expected: damage, a file that was cut off, or a stream
/// that is whole but too short.
std::string shortfall(const Inflated& got, std::size_t expected);

/// Decompress exactly as much as `out` holds. The error is a reason, empty if all went well.
std::string decompress_zstd(std::span<const std::byte> input, std::span<std::byte> out);

Expected<std::vector<std::byte>> compress_gzip(std::span<const std::byte> input,
                                               const std::string& name);
Expected<std::vector<std::byte>> compress_zstd(std::span<const std::byte> input,
                                               const std::string& name);

}  // namespace fluxgs::io
