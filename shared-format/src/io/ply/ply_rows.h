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

class TextCursor {
 public:
  explicit TextCursor(std::span<const std::byte> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

  // The next number; false at the end of the text or if the next word is none. Takes "nan" too.
  template <class T>
  bool number(T& value) {
    constexpr std::string_view kBlank = " \t\r\n";
    text_.remove_prefix(std::min(text_.find_first_not_of(kBlank), text_.size()));
    const std::string_view word =
        text_.substr(0, std::min(text_.find_first_of(kBlank), text_.size()));
    std::array<char, 64> buffer{};  // strtod needs a zero at the end
    if (word.empty() || word.size() >= buffer.size()) return false;
    std::ranges::copy(word, buffer.begin());
    char* end = nullptr;
    if constexpr (std::is_same_v<T, float>)
      value = std::strtof(buffer.data(), &end);
    else
      value = std::strtod(buffer.data(), &end);
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

  std::size_t bytes_left() const {
    const std::size_t begin = text_.find_first_not_of(" \t\r\n");
    return begin == std::string_view::npos ? 0 : text_.size() - begin;
  }

 private:
  std::string_view text_;
};

/// The data section, element by element in the order of the header.
class PlyData {
 public:
  /// `bytes`: behind the header. `name` must outlive this.
  PlyData(std::span<const std::byte> bytes, PlyEncoding encoding, const std::string& name)
      : text_(bytes),
        binary_(bytes, encoding == PlyEncoding::big_endian),
        encoding_(encoding),
        name_(name) {}

  Expected<void> skip(const PlyElement& element) {
    if (is_text() ? text_.skip_element(element) : binary_.skip_element(element, encoding_))
      return {};
    return fail(name_, "element " + sanitized(element.name),
                "its lists run past the end of the file");
  }

  /// Checks that the rows of the next element, which has no lists, are there: lists before it may
  /// have used up what the header's minimum left for them.
  Expected<void> check_size(const PlyElement& element) const {
    const std::uint64_t need = element.count * ply_row_bytes(element, encoding_);
    if (is_text() || need <= binary_.left().size()) return {};
    return fail(name_, "element " + sanitized(element.name),
                fmt::format("needs {} bytes, but the file holds {} from there on", need,
                            binary_.left().size()));
  }

  /// Calls take(row, values) with the values of the properties at `columns` of each row of the
  /// next element, whose size was checked.
  template <class T, class Take>
  Expected<void> read(const PlyElement& element, const std::vector<std::size_t>& columns,
                      const Take& take) {
    std::vector<T> values(columns.size());
    if (is_text()) return read_text(element, columns, values, take);
    std::vector<std::size_t> offsets;
    std::size_t row_bytes = 0;
    for (const PlyProperty& property : element.properties) {
      offsets.push_back(row_bytes);
      row_bytes += ply_type_bytes(property.type);
    }
    const std::byte* row = binary_.left().data();
    for (std::size_t i = 0; i < element.count; ++i, row += row_bytes) {
      for (std::size_t k = 0; k < columns.size(); ++k)
        values[k] = load_as<T>(row + offsets[columns[k]], element.properties[columns[k]].type,
                               binary_.swap());
      take(i, values.data());
    }
    binary_.skip(element.count * row_bytes);
    return {};
  }

  /// Bytes behind the last element that was read, but for blanks at the end of a text.
  std::size_t bytes_left() const { return is_text() ? text_.bytes_left() : binary_.left().size(); }

 private:
  bool is_text() const { return encoding_ == PlyEncoding::ascii; }

  template <class T, class Take>
  Expected<void> read_text(const PlyElement& element, const std::vector<std::size_t>& columns,
                           std::vector<T>& values, const Take& take) {
    std::vector<T> row(element.properties.size());
    for (std::size_t i = 0; i < element.count; ++i) {
      for (std::size_t p = 0; p < row.size(); ++p)
        if (!text_.number(row[p]))
          return fail(name_, fmt::format("element {}, row {}", sanitized(element.name), i),
                      fmt::format("expected a number for property {}",
                                  sanitized(element.properties[p].name)));
      for (std::size_t k = 0; k < columns.size(); ++k) values[k] = row[columns[k]];
      take(i, values.data());
    }
    return {};
  }

  TextCursor text_;
  BinaryCursor binary_;
  PlyEncoding encoding_;
  const std::string& name_;
};

}  // namespace fluxgs::io
