// Checked reading of little-endian bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

namespace fluxgs {

static_assert(std::endian::native == std::endian::little, "values are copied as they are");

/// Takes values off the front; nothing once there are too few bytes.
class ByteReader {
 public:
  /// The bytes must outlive the reader.
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  /// Bytes that are left.
  std::size_t left() const { return rest_.size(); }

  /// A value of a trivially copyable type.
  template <class T>
  std::optional<T> take() {
    static_assert(std::is_trivially_copyable_v<T>);
    if (rest_.size() < sizeof(T)) return std::nullopt;
    T value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_ = rest_.subspan(sizeof value);
    return value;
  }

  /// Unsigned LEB128 of at most 63 bits.
  std::optional<std::uint64_t> take_varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 63; shift += 7) {
      const auto byte = take<std::uint8_t>();
      if (!byte) return std::nullopt;
      value |= std::uint64_t{*byte & 0x7fu} << shift;
      if (*byte < 0x80) return value;
    }
    return std::nullopt;
  }

  /// The next `count` bytes, not copied.
  std::optional<std::span<const std::byte>> take_bytes(std::uint64_t count) {
    if (rest_.size() < count) return std::nullopt;
    const auto front = rest_.first(static_cast<std::size_t>(count));
    rest_ = rest_.subspan(static_cast<std::size_t>(count));
    return front;
  }

  /// Characters up to a zero byte, which is taken as well.
  std::optional<std::string> take_c_string() {
    const void* end = rest_.empty() ? nullptr : std::memchr(rest_.data(), 0, rest_.size());
    if (!end) return std::nullopt;
    const auto length = static_cast<std::size_t>(static_cast<const std::byte*>(end) - rest_.data());
    std::string text(reinterpret_cast<const char*>(rest_.data()), length);
    rest_ = rest_.subspan(length + 1);
    return text;
  }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace fluxgs
