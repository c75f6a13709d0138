// Rows of the elements of a PLY file: text, and binary of either byte order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "fluxgs/error.h"
#include "fluxgs/sanitize.h"
#include "io/byte_window.h"
#include "io/ply/ply_header.h"

namespace fluxgs::io {

static_assert(std::endian::native == std::endian::little, "the binary readers assume it");

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

// Binary data, one number after the other, never past their end.
class BinaryCursor {
 public:
  BinaryCursor(ByteWindow& window, bool swap) : window_(window), swap_(swap) {}

  bool skip_row(const PlyElement& element) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t count = 1;
      if (property.list_count) {
        const std::size_t size = ply_type_bytes(*property.list_count);
        const auto bytes = window_.ahead(size);
        if (size > bytes.size()) return false;
        const auto length = load_as<std::int64_t>(bytes.data(), *property.list_count, swap_);
        if (length < 0) return false;
        count = static_cast<std::uint64_t>(length);
        window_.skip(size);
      }
      if (!window_.skip(count * ply_type_bytes(property.type))) return false;  // count < 2^32
    }
    return true;
  }

  bool skip_element(const PlyElement& element, PlyEncoding encoding) {
    // Sizes without lists were checked with the header.
    if (!element.has_lists()) return window_.skip(element.count * ply_row_bytes(element, encoding));
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (!skip_row(element)) return false;
    }
    return true;
  }

 private:
  ByteWindow& window_;
  bool swap_;
};

class TextCursor {
 public:
  explicit TextCursor(ByteWindow& window) : window_(window) {}

  // The next number; false at the end of the text or if the next word is none. Takes "nan" too.
  template <class T>
  bool number(T& value) {
    std::array<char, 64> buffer{};  // strtod needs a zero at the end
    skip_blanks();
    const std::string_view text = ahead(buffer.size());
    const std::string_view word = text.substr(0, std::min(text.find_first_of(kBlank), text.size()));
    if (word.empty() || word.size() >= buffer.size()) return false;
    std::ranges::copy(word, buffer.begin());
    char* end = nullptr;
    if constexpr (std::is_same_v<T, float>)
      value = std::strtof(buffer.data(), &end);
    else
      value = std::strtod(buffer.data(), &end);
    window_.skip(word.size());
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

  std::uint64_t bytes_left() {
    skip_blanks();
    return window_.left();
  }

 private:
  static constexpr std::string_view kBlank = " \t\r\n";

  std::string_view ahead(std::size_t least) {
    const auto bytes = window_.ahead(least);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  void skip_blanks() {
    for (std::string_view text = ahead(1); !text.empty(); text = ahead(1)) {
      const std::size_t blanks = std::min(text.find_first_not_of(kBlank), text.size());
      window_.skip(blanks);
      if (blanks < text.size()) return;
    }
  }

  ByteWindow& window_;
};

/// The data section, element by element in the order of the header.
class PlyData {
 public:
  /// `begin`: behind the header. `source` and `name` must outlive this.
  PlyData(const ByteSource& source, std::uint64_t begin, PlyEncoding encoding,
          const std::string& name)
      : window_(source, begin), encoding_(encoding), name_(name) {}
  PlyData(const PlyData&) = delete;
  PlyData& operator=(const PlyData&) = delete;

  Expected<void> skip(const PlyElement& element) {
    if (is_text() ? text_.skip_element(element) : binary_.skip_element(element, encoding_))
      return {};
    return lost("element " + sanitized(element.name), "its lists run past the end of the file");
  }

  /// Checks that the rows of the next element, which has no lists, are there: lists before it may
  /// have used up what the header's minimum left for them.
  Expected<void> check_size(const PlyElement& element) const {
    const std::uint64_t need = element.count * ply_row_bytes(element, encoding_);
    if (is_text() || need <= window_.left()) return {};
    return lost(
        "element " + sanitized(element.name),
        fmt::format("needs {} bytes, but the file holds {} from there on", need, window_.left()));
  }

  /// Calls take(row, values) with the values of the properties at `columns` of `count` rows of an
  /// element whose size was checked. `first`: the row that comes next.
  template <class T, class Take>
  Expected<void> read(const PlyElement& element, const std::vector<std::size_t>& columns,
                      std::size_t first, std::size_t count, const Take& take) {
    std::vector<T> values(columns.size());
    return is_text() ? read_text(element, columns, first, count, values, take)
                     : read_binary(element, columns, first, count, values, take);
  }

  /// Bytes behind the last element that was read, but for blanks at the end of a text.
  std::uint64_t bytes_left() { return is_text() ? text_.bytes_left() : window_.left(); }

 private:
  bool is_text() const { return encoding_ == PlyEncoding::ascii; }

  // Of what the file holds, or because it cannot be read.
  std::unexpected<Error> lost(std::string field, std::string what) const {
    if (window_.error()) return std::unexpected(*window_.error());
    return fail(name_, std::move(field), std::move(what));
  }

  template <class T, class Take>
  Expected<void> read_binary(const PlyElement& element, const std::vector<std::size_t>& columns,
                             std::size_t first, std::size_t count, std::vector<T>& values,
                             const Take& take) {
    const bool swap = encoding_ == PlyEncoding::big_endian;
    std::vector<std::size_t> offsets;
    std::size_t row_bytes = 0;
    for (const PlyProperty& property : element.properties) {
      offsets.push_back(row_bytes);
      row_bytes += ply_type_bytes(property.type);
    }
    for (std::size_t i = first; i < first + count; ++i) {
      const auto row = window_.ahead(row_bytes);
      if (row.size() < row_bytes) return lost("element " + element.name, "ends too early");
      for (std::size_t k = 0; k < columns.size(); ++k)
        values[k] =
            load_as<T>(row.data() + offsets[columns[k]], element.properties[columns[k]].type, swap);
      take(i, values.data());
      window_.skip(row_bytes);
    }
    return {};
  }

  template <class T, class Take>
  Expected<void> read_text(const PlyElement& element, const std::vector<std::size_t>& columns,
                           std::size_t first, std::size_t count, std::vector<T>& values,
                           const Take& take) {
    std::vector<T> row(element.properties.size());
    for (std::size_t i = first; i < first + count; ++i) {
      for (std::size_t p = 0; p < row.size(); ++p)
        if (!text_.number(row[p]))
          return lost(fmt::format("element {}, row {}", sanitized(element.name), i),
                      fmt::format("expected a number for property {}",
                                  sanitized(element.properties[p].name)));
      for (std::size_t k = 0; k < columns.size(); ++k) values[k] = row[columns[k]];
      take(i, values.data());
    }
    return {};
  }

  ByteWindow window_;
  PlyEncoding encoding_;
  const std::string& name_;
  TextCursor text_{window_};
  BinaryCursor binary_{window_, encoding_ == PlyEncoding::big_endian};
};

}  // namespace fluxgs::io
