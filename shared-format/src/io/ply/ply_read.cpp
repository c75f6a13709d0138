#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "cloud/activation.h"
#include "cloud/cloud_memory.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/sanitize.h"
#include "io/ply/ply_columns.h"
#include "io/ply/ply_header.h"

namespace fluxgs {
namespace {

using namespace io;

static_assert(std::endian::native == std::endian::little, "the binary readers assume it");

constexpr std::size_t kPlain = 14;  // properties of a splat besides f_rest_*
constexpr std::array<const char*, kPlain> kNames{
    "x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
    "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};
constexpr std::size_t kMaxValues = kPlain + 45;

// Where the values of a splat stand in a row of the file: kNames, then f_rest_0 ….
struct Columns {
  int sh_degree = 0;
  std::vector<std::size_t> property;  // index among the element's properties
};

// The numbers of one splat in the order of Columns.
using Values = std::array<float, kMaxValues>;

Expected<Columns> find_columns(const PlyElement& vertex, const std::string& name) {
  if (vertex.has_lists()) {
    return fail(name, "element vertex", "holds a list property; expected only scalars");
  }
  const auto degree = ply_sh_degree(vertex, name);
  if (!degree) return std::unexpected(degree.error());
  Columns columns;
  columns.sh_degree = *degree;
  const std::size_t count = kPlain + 3 * static_cast<std::size_t>(sh_rest_count(*degree));
  for (std::size_t i = 0; i < count; ++i) {
    const auto found = find_ply_property(
        vertex, i < kPlain ? kNames[i] : fmt::format("f_rest_{}", i - kPlain), "3DGS .ply", name);
    if (!found) return std::unexpected(found.error());
    columns.property.push_back(*found);
  }
  return columns;
}

// Infinite logits are what converters make of opacities of exactly 0 and 1 in 8 bits
// (splat-transform 3.7: most splats of some scenes).
float finite_logit(float value) { return std::isinf(value) ? logit(value > 0 ? 1 : 0) : value; }

void store(const Values& v, std::size_t i, SplatCloud& cloud) {
  cloud.positions[i] = {v[0], v[1], v[2]};
  cloud.sh_dc[i] = {v[3], v[4], v[5]};
  cloud.opacity_logits[i] = finite_logit(v[6]);
  cloud.log_scales[i] = {v[7], v[8], v[9]};
  cloud.rotations[i] = glm::quat(v[10], v[11], v[12], v[13]);  // w first
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) {
    const float* red = &v[kPlain + k];  // channel-major
    cloud.sh_rest[i * rest + k] = {red[0], red[rest], red[2 * rest]};
  }
}

template <class T>
T load(const std::byte* at, bool swap) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), at, sizeof(T));
  if (swap) std::ranges::reverse(raw);
  return std::bit_cast<T>(raw);
}

template <class T>
T load_as(const std::byte* at, PlyType type, bool swap) {
  switch (type) {
    case PlyType::int8:
      return static_cast<T>(load<std::int8_t>(at, swap));
    case PlyType::uint8:
      return static_cast<T>(load<std::uint8_t>(at, swap));
    case PlyType::int16:
      return static_cast<T>(load<std::int16_t>(at, swap));
    case PlyType::uint16:
      return static_cast<T>(load<std::uint16_t>(at, swap));
    case PlyType::int32:
      return static_cast<T>(load<std::int32_t>(at, swap));
    case PlyType::uint32:
      return static_cast<T>(load<std::uint32_t>(at, swap));
    case PlyType::float32:
      return static_cast<T>(load<float>(at, swap));
    case PlyType::float64:
      break;
  }
  return static_cast<T>(load<double>(at, swap));
}

// A walk over the data section, one number after the other, never past its end.
class BinaryCursor {
 public:
  BinaryCursor(std::span<const std::byte> bytes, bool swap) : left_(bytes), swap_(swap) {}

  bool skip(std::uint64_t bytes) {
    if (bytes > left_.size()) return false;
    left_ = left_.subspan(static_cast<std::size_t>(bytes));
    return true;
  }

  bool skip_row(const PlyElement& element) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t count = 1;
      if (property.list_count) {
        const std::size_t size = ply_type_bytes(*property.list_count);
        if (size > left_.size()) return false;
        const auto length = load_as<std::int64_t>(left_.data(), *property.list_count, swap_);
        if (length < 0) return false;
        count = static_cast<std::uint64_t>(length);
        skip(size);
      }
      if (!skip(count * ply_type_bytes(property.type))) return false;  // count < 2^32
    }
    return true;
  }

  bool skip_element(const PlyElement& element, PlyEncoding encoding) {
    // Sizes without lists were checked with the header.
    if (!element.has_lists()) return skip(element.count * ply_row_bytes(element, encoding));
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (!skip_row(element)) return false;
    }
    return true;
  }

  std::span<const std::byte> left() const { return left_; }
  bool swap() const { return swap_; }

 private:
  std::span<const std::byte> left_;
  bool swap_;
};

void read_binary_rows(const BinaryCursor& cursor, const PlyElement& vertex, const Columns& columns,
                      SplatCloud& cloud) {
  std::vector<std::size_t> offsets;
  std::size_t row_bytes = 0;
  for (const PlyProperty& property : vertex.properties) {
    offsets.push_back(row_bytes);
    row_bytes += ply_type_bytes(property.type);
  }
  const std::byte* row = cursor.left().data();
  Values values{};
  for (std::size_t i = 0; i < cloud.size(); ++i, row += row_bytes) {
    for (std::size_t k = 0; k < columns.property.size(); ++k) {
      const std::size_t p = columns.property[k];
      values[k] = load_as<float>(row + offsets[p], vertex.properties[p].type, cursor.swap());
    }
    store(values, i, cloud);
  }
}

class TextCursor {
 public:
  explicit TextCursor(std::span<const std::byte> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

  // The next number; false at the end of the text or if the next word is none.
  bool number(float& value) {
    constexpr std::string_view kBlank = " \t\r\n";
    text_.remove_prefix(std::min(text_.find_first_not_of(kBlank), text_.size()));
    const std::string_view word =
        text_.substr(0, std::min(text_.find_first_of(kBlank), text_.size()));
    std::array<char, 64> buffer{};  // strtof needs a zero at the end
    if (word.empty() || word.size() >= buffer.size()) return false;
    std::ranges::copy(word, buffer.begin());
    char* end = nullptr;
    value = std::strtof(buffer.data(), &end);
    text_.remove_prefix(word.size());
    return end == buffer.data() + word.size();
  }

  bool skip_element(const PlyElement& element) {
    for (std::uint64_t row = 0; row < element.count && !element.properties.empty(); ++row) {
      for (const PlyProperty& property : element.properties) {
        float value = 1;
        if (property.list_count && (!number(value) || !(value >= 0 && value < 1e18f))) return false;
        // Every number takes bytes, so that a false count ends with the file.
        for (auto left = static_cast<std::uint64_t>(value); left > 0; --left) {
          if (!number(value)) return false;
        }
      }
    }
    return true;
  }

 private:
  std::string_view text_;
};

Expected<void> read_text_rows(TextCursor& cursor, const PlyElement& vertex, const Columns& columns,
                              SplatCloud& cloud, const std::string& name) {
  std::vector<float> row(vertex.properties.size());
  Values values{};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (std::size_t p = 0; p < row.size(); ++p) {
      if (cursor.number(row[p])) continue;
      return fail(
          name, fmt::format("element vertex, row {}", i),
          fmt::format("expected a number for property {}", sanitized(vertex.properties[p].name)));
    }
    for (std::size_t k = 0; k < columns.property.size(); ++k) values[k] = row[columns.property[k]];
    store(values, i, cloud);
  }
  return {};
}

// The data section, element by element: the rows of `vertex` become splats, all others are skipped,
// those behind it too, so that a file cut anywhere is noticed.
class DataReader {
 public:
  DataReader(std::span<const std::byte> data, PlyEncoding encoding, const std::string& name)
      : text_(data),
        binary_(data, encoding == PlyEncoding::big_endian),
        encoding_(encoding),
        name_(name) {}

  Expected<void> skip(const PlyElement& element) {
    if (is_text() ? text_.skip_element(element) : binary_.skip_element(element, encoding_)) {
      return {};
    }
    return fail(name_, "element " + sanitized(element.name),
                "its lists run past the end of the file");
  }

  Expected<SplatCloud> read(const PlyElement& vertex, const Columns& columns) {
    // Lists before the vertices may have used up what the header's minimum left for them.
    const std::uint64_t need = vertex.count * ply_row_bytes(vertex, encoding_);
    if (!is_text() && need > binary_.left().size()) {
      return fail(name_, "element vertex",
                  fmt::format("needs {} bytes, but the file holds {} from there on", need,
                              binary_.left().size()));
    }
    auto cloud = allocate_cloud(static_cast<std::size_t>(vertex.count), columns.sh_degree, name_);
    if (!cloud) return cloud;
    if (is_text()) {
      const auto done = read_text_rows(text_, vertex, columns, *cloud, name_);
      if (!done) return std::unexpected(done.error());
    } else {
      read_binary_rows(binary_, vertex, columns, *cloud);
      binary_.skip(need);
    }
    return cloud;
  }

 private:
  bool is_text() const { return encoding_ == PlyEncoding::ascii; }

  TextCursor text_;
  BinaryCursor binary_;
  PlyEncoding encoding_;
  const std::string& name_;
};

Expected<SplatCloud> read_elements(std::span<const std::byte> bytes, const PlyHeader& header,
                                   const std::string& name) {
  const auto vertex = std::ranges::find(header.elements, "vertex", &PlyElement::name);
  if (vertex == header.elements.end()) {
    return fail(name, "header", "has no element \"vertex\"; expected one row of it per splat");
  }
  const auto columns = find_columns(*vertex, name);
  if (!columns) return std::unexpected(columns.error());
  DataReader data(bytes.subspan(header.size), header.encoding, name);
  Expected<SplatCloud> cloud;
  for (auto element = header.elements.begin(); element != header.elements.end(); ++element) {
    if (element == vertex) {
      cloud = data.read(*vertex, *columns);
      if (!cloud) return cloud;
    } else if (auto skipped = data.skip(*element); !skipped) {
      return std::unexpected(skipped.error());
    }
  }
  return cloud;
}

}  // namespace

bool is_ply(std::span<const std::byte> bytes) {
  constexpr std::string_view kMagic = "ply";
  return bytes.size() > kMagic.size() &&
         std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0 &&
         (bytes[3] == std::byte{'\n'} || bytes[3] == std::byte{'\r'});
}

Expected<SceneFile> read_ply(std::span<const std::byte> bytes, const std::string& name) {
  const auto header = parse_ply_header(bytes, name);
  if (!header) return std::unexpected(header.error());
  auto cloud = read_elements(bytes, *header, name);
  if (!cloud) return std::unexpected(cloud.error());
  SceneFile scene;
  scene.cloud = std::move(*cloud);
  scene.dropped = drop_non_finite(scene.cloud);
  scene.format = "ply";
  scene.attribute_bits = float_attribute_bits(scene.cloud.sh_degree);
  scene.bytes = bytes.size();
  return scene;
}

}  // namespace fluxgs
