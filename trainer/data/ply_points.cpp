#include "trainer/data/ply_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"
#include "trainer/data/file_bytes.h"

namespace fluxgs {
namespace {

struct PlyType {
  std::string_view name, alias;
  std::size_t size;
  double (*read)(const char*);
};

template <class T>
double read_as(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

constexpr std::array<PlyType, 8> kTypes{{{"char", "int8", 1, read_as<std::int8_t>},
                                         {"uchar", "uint8", 1, read_as<std::uint8_t>},
                                         {"short", "int16", 2, read_as<std::int16_t>},
                                         {"ushort", "uint16", 2, read_as<std::uint16_t>},
                                         {"int", "int32", 4, read_as<std::int32_t>},
                                         {"uint", "uint32", 4, read_as<std::uint32_t>},
                                         {"float", "float32", 4, read_as<float>},
                                         {"double", "float64", 8, read_as<double>}}};

constexpr std::array<std::string_view, 6> kNames{"x", "y", "z", "red", "green", "blue"};

struct PlyHeader {
  bool ascii = false;
  std::uint64_t count = 0;
  std::size_t data_start = 0, stride = 0, columns = 0;
  struct Property {
    const PlyType* type = nullptr;
    std::size_t offset = 0, column = 0;
  };
  std::array<Property, kNames.size()> properties;  // of kNames
};

/// One line of the header; false if it is not understood. `element` counts the elements seen.
bool parse_line(const std::string& line, PlyHeader& header, int& element) {
  std::istringstream words(line);
  std::string key, first, second;
  words >> key >> first >> second;
  if (key == "format") {
    header.ascii = first == "ascii";
    return header.ascii || first == "binary_little_endian";
  }
  if (key == "element") {
    if (++element > 1) return true;  // Faces and others come after the vertices and are not read.
    header.count = std::strtoull(second.c_str(), nullptr, 10);
    return first == "vertex";
  }
  if (key != "property" || element != 1) return true;
  const auto type = std::ranges::find_if(
      kTypes, [&](const PlyType& t) { return t.name == first || t.alias == first; });
  if (type == kTypes.end()) return false;
  const auto name = std::ranges::find(kNames, second);
  if (name != kNames.end())
    header.properties[static_cast<std::size_t>(name - kNames.begin())] = {&*type, header.stride,
                                                                          header.columns};
  header.stride += type->size;
  ++header.columns;
  return true;
}

Expected<PlyHeader> parse_header(const std::string& text, const std::string& file) {
  PlyHeader header;
  int element = 0;
  std::size_t at = 0;
  for (bool first = true;; first = false) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos || end - at > 1024)
      return fail(file, "header", "incomplete, expected a .ply header up to end_header");
    std::string line = text.substr(at, end - at);
    if (line.ends_with('\r')) line.pop_back();
    at = end + 1;
    if (first && line != "ply") return fail(file, "header", "expected a .ply file");
    if (line == "end_header") break;
    if (!parse_line(line, header, element))
      return fail(file, "header", "not understood: \"" + one_line(line) + "\"");
  }
  header.data_start = at;
  if (!header.properties[0].type || !header.properties[1].type || !header.properties[2].type)
    return fail(file, "header", "expected vertices with the properties x, y and z");
  // An ascii row has at least one digit and one separator a column.
  const std::uint64_t smallest = header.ascii ? 2 * header.columns : header.stride;
  const std::uint64_t room = (text.size() - at + (header.ascii ? 1 : 0)) / smallest;
  if (header.count > room)
    return fail(file, "header",
                fmt::format("promises {} vertices, but the file has room for at most {}",
                            header.count, room));
  return header;
}

glm::u8vec3 to_color(const PlyHeader& header, const std::array<double, kNames.size()>& v) {
  if (!header.properties[3].type || !header.properties[4].type || !header.properties[5].type)
    return glm::u8vec3(255);
  const auto byte = [](double c) {
    return static_cast<std::uint8_t>(c > 0 ? std::min(c, 255.0) : 0.0);
  };
  return {byte(v[3]), byte(v[4]), byte(v[5])};
}

/// The values of kNames in the next ascii row; false if the text ends or is not a number.
bool read_ascii(std::istringstream& rows, const PlyHeader& header,
                std::array<double, kNames.size()>& values) {
  for (std::size_t column = 0; column < header.columns; ++column) {
    std::string word;
    if (!(rows >> word)) return false;
    char* end = nullptr;
    const double value =
        std::strtod(word.c_str(), &end);  // Takes "nan", which operator>> does not.
    if (*end != '\0') return false;
    for (std::size_t i = 0; i < kNames.size(); ++i)
      if (header.properties[i].type && header.properties[i].column == column) values[i] = value;
  }
  return true;
}

}  // namespace

Expected<void> read_ply_points(const std::filesystem::path& file, Source& source) {
  const auto text = read_text(file);
  if (!text) return std::unexpected(text.error());
  const auto header = parse_header(*text, file.string());
  if (!header) return std::unexpected(header.error());

  std::istringstream rows(header->ascii ? text->substr(header->data_start) : "");
  std::size_t dropped = 0;
  for (std::uint64_t row = 0; row < header->count; ++row) {
    std::array<double, kNames.size()> values{};
    if (header->ascii) {
      if (!read_ascii(rows, *header, values))
        return fail(file.string(), fmt::format("vertex {}", row),
                    fmt::format("expected {} numbers", header->columns));
    } else {
      const char* bytes = text->data() + header->data_start + row * header->stride;
      for (std::size_t i = 0; i < kNames.size(); ++i)
        if (const auto& p = header->properties[i]; p.type)
          values[i] = p.type->read(bytes + p.offset);
    }
    dropped += !add_point(source, {values[0], values[1], values[2]}, to_color(*header, values));
  }
  if (dropped > 0)
    source.warnings.push_back(
        fmt::format("{}: {} points that are not finite were dropped", file.string(), dropped));
  return {};
}

}  // namespace fluxgs
