// The wire format of Protocol Buffers (protobuf.dev, "Encoding"), as far as ONNX models use it.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace fluxgs::networks {

/// Encoding of a field's value. Groups (3 and 4) are long deprecated and not read.
enum class Wire : std::uint8_t { varint = 0, fixed64 = 1, bytes = 2, fixed32 = 5 };

struct Field {
  std::uint32_t number = 0;
  Wire wire = Wire::varint;
  std::uint64_t integer = 0;         ///< unless wire is bytes
  std::span<const std::byte> bytes;  ///< if wire is bytes

  std::int64_t as_int() const { return static_cast<std::int64_t>(integer); }
  float as_float() const { return std::bit_cast<float>(static_cast<std::uint32_t>(integer)); }
  std::string_view as_text() const {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
};

/// Takes the fields of one message off the front.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::byte> message) : rest_(message) {}

  bool done() const { return rest_.empty(); }

  /// Nothing if the message is malformed: cut short, a varint beyond 64 bits, or a group.
  std::optional<Field> next() {
    const auto key = take_varint();
    if (!key || *key >> 3 == 0 || *key >> 3 >= 1u << 29) return std::nullopt;
    Field field;
    field.number = static_cast<std::uint32_t>(*key >> 3);
    field.wire = static_cast<Wire>(*key & 7);
    switch (field.wire) {
      case Wire::varint:
        return with_integer(field, take_varint());
      case Wire::fixed64:
        return with_integer(field, take_fixed(8));
      case Wire::fixed32:
        return with_integer(field, take_fixed(4));
      case Wire::bytes:
        break;
      default:
        return std::nullopt;
    }
    const auto size = take_varint();
    if (!size || *size > rest_.size()) return std::nullopt;
    field.bytes = rest_.first(static_cast<std::size_t>(*size));
    rest_ = rest_.subspan(field.bytes.size());
    return field;
  }

  /// For packed fields too, which are varints without keys.
  std::optional<std::uint64_t> take_varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64 && !rest_.empty(); shift += 7) {
      const auto byte = static_cast<std::uint8_t>(rest_.front());
      rest_ = rest_.subspan(1);
      if (shift == 63 && byte > 1) return std::nullopt;
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if (byte < 0x80) return value;
    }
    return std::nullopt;
  }

 private:
  static std::optional<Field> with_integer(Field field, std::optional<std::uint64_t> value) {
    if (!value) return std::nullopt;
    field.integer = *value;
    return field;
  }

  std::optional<std::uint64_t> take_fixed(std::size_t size) {
    if (rest_.size() < size) return std::nullopt;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t(rest_[i]) << (8 * i);
    rest_ = rest_.subspan(size);
    return value;
  }

  std::span<const std::byte> rest_;
};

/// Appends the fields of one message.
class FieldWriter {
 public:
  void integer(std::uint32_t number, std::int64_t value) {
    key(number, Wire::varint);
    varint(static_cast<std::uint64_t>(value));
  }
  void real(std::uint32_t number, float value) {
    key(number, Wire::fixed32);
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (unsigned i = 0; i < 4; ++i) bytes_.push_back(static_cast<std::byte>(bits >> (8 * i)));
  }
  void bytes(std::uint32_t number, std::span<const std::byte> value) {
    key(number, Wire::bytes);
    varint(value.size());
    bytes_.insert(bytes_.end(), value.begin(), value.end());
  }
  void text(std::uint32_t number, std::string_view value) {
    bytes(number, std::as_bytes(std::span(value)));
  }
  void message(std::uint32_t number, const FieldWriter& value) { bytes(number, value.bytes_); }

  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void key(std::uint32_t number, Wire wire) {
    varint(std::uint64_t{number} << 3 | static_cast<std::uint64_t>(wire));
  }
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<std::byte>(value | 0x80));
    bytes_.push_back(static_cast<std::byte>(value));
  }

  std::vector<std::byte> bytes_;
};

}  // namespace fluxgs::networks
