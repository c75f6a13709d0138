#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string_view>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "cloud/activation.h"
#include "fluxgs/io/compressed_ply.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/sanitize.h"
#include "io/ply/compressed_ply_layout.h"
#include "io/ply/ply_columns.h"
#include "io/ply/ply_filter.h"
#include "io/ply/ply_header.h"
#include "io/ply/ply_view.h"
#include "io/whole_cloud.h"

namespace fluxgs {
namespace {

using namespace io;

static_assert(std::endian::native == std::endian::little, "the columns are copied as they are");

// The rows of an element, and where in a row the properties asked for begin.
struct Table {
  std::span<const std::byte> rows;
  std::size_t row_bytes = 0;
  std::uint64_t count = 0;
  std::vector<std::size_t> offsets;

  template <class T>
  T value(std::size_t row, std::size_t column) const {
    T value;
    std::memcpy(&value, rows.data() + row * row_bytes + offsets[column], sizeof value);
    return value;
  }
};

struct Tables {
  Table chunk, vertex, sh;
  bool has_colour_bounds = false;
  int sh_degree = 0;
};

struct Range {
  glm::dvec3 low{0}, high{1};

  // In float64, where no difference of two floats overflows.
  glm::dvec3 at(const glm::dvec3& fraction) const { return glm::mix(low, high, fraction); }
};

struct Chunk {
  Range position, log_scale, colour;
};

const PlyElement* find_element(const PlyHeader& header, std::string_view element) {
  const auto found = std::ranges::find(header.elements, element, &PlyElement::name);
  return found == header.elements.end() ? nullptr : &*found;
}

// The bytes of an element, which the header's check has found to be there.
Table table_of(const PlyHeader& header, const PlyElement& element,
               std::span<const std::byte> bytes) {
  std::uint64_t begin = header.size;
  for (const PlyElement* before = header.elements.data(); before != &element; ++before) {
    begin += before->count * ply_row_bytes(*before, header.encoding);
  }
  const std::uint64_t row = ply_row_bytes(element, header.encoding);
  return {
      bytes.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(element.count * row)),
      static_cast<std::size_t>(row),
      element.count,
      {}};
}

Expected<void> add_column(Table& table, const PlyElement& element, std::string_view property,
                          PlyType type, std::string_view type_name, const std::string& name) {
  const auto found = find_ply_property(element, property, "compressed .ply", name);
  if (!found) return std::unexpected(found.error());
  if (element.properties[*found].type != type) {
    return fail(name, "element " + element.name,
                fmt::format("property {} is of another type; expected {}", property, type_name));
  }
  std::size_t offset = 0;
  for (std::size_t i = 0; i < *found; ++i) offset += ply_type_bytes(element.properties[i].type);
  table.offsets.push_back(offset);
  return {};
}

Expected<Table> find_chunks(const PlyHeader& header, std::span<const std::byte> bytes,
                            std::uint64_t splats, const std::string& name) {
  const PlyElement* element = find_element(header, "chunk");
  if (element == nullptr) {
    return fail(name, "header", "has no element \"chunk\"; expected one row of it per 256 splats");
  }
  Table chunk = table_of(header, *element, bytes);
  const std::uint64_t expected = splats / kChunkSplats + (splats % kChunkSplats != 0 ? 1 : 0);
  if (chunk.count != expected) {
    return fail(name, "element chunk",
                fmt::format("has {} rows; expected {}, one per {} of the {} splats", chunk.count,
                            expected, kChunkSplats, splats));
  }
  const bool colours = std::ranges::any_of(element->properties, [](const PlyProperty& p) {
    return std::ranges::find(kChunkNames.begin() + kBounds, kChunkNames.end(), p.name) !=
           kChunkNames.end();
  });
  for (std::size_t i = 0; i < (colours ? kChunkNames.size() : kBounds); ++i) {
    const auto added = add_column(chunk, *element, kChunkNames[i], PlyType::float32, "float", name);
    if (!added) return std::unexpected(added.error());
  }
  return chunk;
}

Expected<Table> find_vertices(const PlyHeader& header, std::span<const std::byte> bytes,
                              const std::string& name) {
  const PlyElement* element = find_element(header, "vertex");
  if (element == nullptr) {
    return fail(name, "header", "has no element \"vertex\"; expected one row of it per splat");
  }
  Table vertex = table_of(header, *element, bytes);
  for (const std::string_view packed : kPackedNames) {
    const auto added = add_column(vertex, *element, packed, PlyType::uint32, "uint", name);
    if (!added) return std::unexpected(added.error());
  }
  return vertex;
}

// The optional rows of f_rest_*; without them the degree is 0.
Expected<void> find_sh(const PlyHeader& header, std::span<const std::byte> bytes, Tables& tables,
                       const std::string& name) {
  const PlyElement* element = find_element(header, "sh");
  if (element == nullptr) return {};
  const auto degree = ply_sh_degree(*element, kMaxShDegree, name);
  if (!degree) return std::unexpected(degree.error());
  tables.sh_degree = *degree;
  tables.sh = table_of(header, *element, bytes);
  if (tables.sh.count != tables.vertex.count) {
    return fail(name, "element sh",
                fmt::format("has {} rows; expected {}, one per splat", tables.sh.count,
                            tables.vertex.count));
  }
  for (int i = 0; i < 3 * sh_rest_count(*degree); ++i) {
    const auto added =
        add_column(tables.sh, *element, fmt::format("f_rest_{}", i), PlyType::uint8, "uchar", name);
    if (!added) return std::unexpected(added.error());
  }
  return {};
}

Expected<Tables> find_tables(const PlyHeader& header, std::span<const std::byte> bytes,
                             const std::string& name) {
  if (header.encoding != PlyEncoding::little_endian) {
    return fail(name, "header", "a compressed .ply is expected to be binary_little_endian");
  }
  for (const PlyElement& element : header.elements) {
    if (!element.has_lists()) continue;
    return fail(name, "element " + sanitized(element.name),
                "holds a list property; expected only scalars");
  }
  Tables tables;
  auto vertex = find_vertices(header, bytes, name);
  if (!vertex) return std::unexpected(vertex.error());
  tables.vertex = std::move(*vertex);
  auto chunk = find_chunks(header, bytes, tables.vertex.count, name);
  if (!chunk) return std::unexpected(chunk.error());
  tables.chunk = std::move(*chunk);
  tables.has_colour_bounds = tables.chunk.offsets.size() > kBounds;
  if (auto sh = find_sh(header, bytes, tables, name); !sh) return std::unexpected(sh.error());
  return tables;
}

Expected<Chunk> read_chunk(const Tables& tables, std::size_t row, const std::string& name) {
  std::array<double, kChunkNames.size()> bounds{};
  for (std::size_t i = 0; i < tables.chunk.offsets.size(); ++i) {
    bounds[i] = tables.chunk.value<float>(row, i);
    if (std::isfinite(bounds[i])) continue;
    return fail(name, fmt::format("element chunk, row {}", row),
                fmt::format("{} is {}; expected a finite number", kChunkNames[i], bounds[i]));
  }
  const auto range = [&](std::size_t at) {
    return Range{{bounds[at], bounds[at + 1], bounds[at + 2]},
                 {bounds[at + 3], bounds[at + 4], bounds[at + 5]}};
  };
  return Chunk{range(0), range(6), tables.has_colour_bounds ? range(12) : Range{}};
}

// The bits from `shift` on as a fraction, 0…1.
double fraction(std::uint32_t word, int shift, int bits) {
  const std::uint32_t most = (1u << bits) - 1;
  return static_cast<double>((word >> shift) & most) / most;
}

glm::dvec3 unpack_vector(std::uint32_t word) {
  return {fraction(word, 21, 11), fraction(word, 11, 10), fraction(word, 0, 11)};
}

glm::quat unpack_rotation(std::uint32_t word) {
  std::array<double, 4> q{};  // w, x, y, z
  const std::uint32_t largest = word >> 30;
  double squares = 0;
  int shift = 20;
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (i == largest) continue;
    q[i] = (fraction(word, shift, 10) - 0.5) * std::numbers::sqrt2;
    squares += q[i] * q[i];
    shift -= 10;
  }
  q[largest] = std::sqrt(std::max(0.0, 1 - squares));
  return glm::quat(glm::dquat(q[0], q[1], q[2], q[3]));
}

float unpack_sh(std::uint8_t level) {
  if (level == 0) return -4;
  if (level == 255) return 4;
  return (static_cast<float>(level) + 0.5f) / 32 - 4;
}

// Splat `row` of the file becomes splat i of the cloud.
void store(const Tables& tables, const Chunk& chunk, const std::array<float, 256>& logits,
           std::size_t row, std::size_t i, SplatCloud& cloud) {
  const auto word = [&](std::size_t column) {
    return tables.vertex.value<std::uint32_t>(row, column);
  };
  cloud.positions[i] = glm::vec3(chunk.position.at(unpack_vector(word(0))));
  cloud.rotations[i] = unpack_rotation(word(1));
  cloud.log_scales[i] = glm::vec3(chunk.log_scale.at(unpack_vector(word(2))));
  const std::uint32_t packed = word(3);
  const glm::dvec3 colour =
      chunk.colour.at({fraction(packed, 24, 8), fraction(packed, 16, 8), fraction(packed, 8, 8)});
  for (int c = 0; c < 3; ++c) cloud.sh_dc[i][c] = dc_of(colour[c]);
  cloud.opacity_logits[i] = logits[packed & 255];
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const auto stored = static_cast<std::size_t>(sh_rest_count(tables.sh_degree));
  const auto sh = [&](std::size_t column) {
    return unpack_sh(tables.sh.value<std::uint8_t>(row, column));
  };
  for (std::size_t k = 0; k < rest; ++k) {  // channel-major
    cloud.sh_rest[i * rest + k] = {sh(k), sh(stored + k), sh(2 * stored + k)};
  }
}

AttributeBits bits_of(const Tables& tables) {
  AttributeBits bits{
      {"position", 32}, {"rotation", 32}, {"scale", 32}, {"sh_dc", 24}, {"opacity", 8}};
  if (tables.sh_degree > 0) bits["sh_rest"] = 24 * sh_rest_count(tables.sh_degree);
  if (tables.vertex.count > 0) {
    bits["chunks"] = 8 * static_cast<double>(tables.chunk.rows.size()) /
                     static_cast<double>(tables.vertex.count);
  }
  return bits;
}

}  // namespace

bool is_compressed_ply(std::span<const std::byte> bytes) {
  if (!is_ply(bytes)) return false;
  const auto header = parse_ply_header(bytes, "");
  if (!header) return false;
  const PlyElement* vertex = find_element(*header, "vertex");
  return vertex != nullptr && std::ranges::find(vertex->properties, "packed_position",
                                                &PlyProperty::name) != vertex->properties.end();
}

Expected<SceneFile> read_compressed_ply(std::span<const std::byte> bytes, const std::string& name,
                                        SplatSink& sink) {
  const auto header = parse_ply_header(bytes, name);
  if (!header) return std::unexpected(header.error());
  const auto tables = find_tables(*header, bytes, name);
  if (!tables) return std::unexpected(tables.error());
  const ComingSplats coming{static_cast<std::size_t>(tables->vertex.count), tables->sh_degree};
  const auto degree = sink.begin(coming);
  if (!degree) return std::unexpected(degree.error());
  const auto logits = logits_of_bytes();
  static_assert(kSplatsOfAPart % kChunkSplats == 0);
  SceneFile scene;
  const auto fill = [&](std::size_t first, SplatCloud& part) -> Expected<void> {
    for (std::size_t begin = 0; begin < part.size(); begin += kChunkSplats) {
      const auto chunk = read_chunk(*tables, (first + begin) / kChunkSplats, name);
      if (!chunk) return std::unexpected(chunk.error());
      const std::size_t end = std::min(part.size(), begin + kChunkSplats);
      for (std::size_t k = begin; k < end; ++k) store(*tables, *chunk, logits, first + k, k, part);
    }
    return {};
  };
  // Colours beyond float after the change of scale are dropped
  if (auto done = hand_on(coming, *degree, name, sink, scene, fill); !done)
    return std::unexpected(done.error());
  scene.cloud.filter = filter_of_comments(header->comments);
  scene.start = view_of_comments(header->comments);
  scene.format = "compressed.ply";
  scene.attribute_bits = bits_of(*tables);
  scene.bytes = bytes.size();
  return scene;
}

Expected<SceneFile> read_compressed_ply(std::span<const std::byte> bytes, const std::string& name) {
  return read_whole(name, [&](SplatSink& sink) { return read_compressed_ply(bytes, name, sink); });
}

}  // namespace fluxgs
