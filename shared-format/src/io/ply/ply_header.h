// The header of a PLY file (Turk 1994), and what it promises about the bytes behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/byte_source.h"
#include "fluxgs/error.h"

namespace fluxgs::io {

enum class PlyEncoding { ascii, little_endian, big_endian };
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  std::optional<PlyType> list_count;  ///< a list: the type of its length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;  ///< behind the word "comment", of all places
  std::size_t size = 0;               ///< bytes; the data begin here
};

/// The words of a line, between blanks.
std::vector<std::string_view> words_of(std::string_view line);

/// The number that a word is, as every C locale and C++ library reads it: those of Android's NDK
/// r27 and of Emscripten have std::from_chars for integers only.
std::optional<double> number_of(std::string_view word);

std::size_t ply_type_bytes(PlyType type);

/// The least bytes that one row of the element can take (exact for binary rows without lists).
std::uint64_t ply_row_bytes(const PlyElement& element, PlyEncoding encoding);

/// Parse the header and check that the file is large enough for all that it promises.
Expected<PlyHeader> parse_ply_header(std::span<const std::byte> bytes, const std::string& name);
/// The same of the beginning of a file of `size` bytes.
Expected<PlyHeader> parse_ply_header(std::span<const std::byte> begin, std::uint64_t size,
                                     const std::string& name);
/// The same of a file that need not be in memory.
Expected<PlyHeader> read_ply_header(const ByteSource& source, const std::string& name);

}  // namespace fluxgs::io
