// Streams of bits, the lowest of a byte first; zeros up to a whole byte at their end.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "codec/bytes.h"
#include "fluxgs/byte_reader.h"

namespace fluxgs::codec {

class BitWriter {
 public:
  explicit BitWriter(Bytes& out) : out_(out) {}

  /// The `count` lowest bits of `value`, at most 32; the others must be zero.
  void put(std::uint64_t value, unsigned count) {
    buffer_ |= value << filled_;
    for (filled_ += count; filled_ >= 8; filled_ -= 8, buffer_ >>= 8)
      out_.push_back(static_cast<std::byte>(buffer_));
  }

  /// Exponential Golomb code of order `order`, of a value below 2³¹: small values in few bits.
  void put_golomb(std::uint32_t value, unsigned order) {
    const std::uint32_t high = (value >> order) + 1;
    const unsigned length = static_cast<unsigned>(std::bit_width(high)) - 1;
    put((std::uint64_t{1} << length) - 1, length);
    put(0, 1);
    put(high - (std::uint32_t{1} << length), length);
    put(value & ((1u << order) - 1), order);
  }

  void finish() {
    if (filled_ > 0) out_.push_back(static_cast<std::byte>(buffer_));
    buffer_ = filled_ = 0;
  }

 private:
  Bytes& out_;
  std::uint64_t buffer_ = 0;
  unsigned filled_ = 0;
};

/// Bits that put_golomb() takes.
constexpr unsigned golomb_bits(std::uint32_t value, unsigned order) {
  return 2 * static_cast<unsigned>(std::bit_width((value >> order) + 1)) - 1 + order;
}

/// Takes bits off the bytes of a reader, which is to be used again after the last.
class BitReader {
 public:
  explicit BitReader(ByteReader& in) : in_(in) {}

  /// At most 32; nothing once there are too few.
  std::optional<std::uint32_t> take(unsigned count) {
    for (; filled_ < count; filled_ += 8) {
      const auto byte = in_.take<std::uint8_t>();
      if (!byte) return std::nullopt;
      buffer_ |= std::uint64_t{*byte} << filled_;
    }
    const auto value = static_cast<std::uint32_t>(buffer_ & ((std::uint64_t{1} << count) - 1));
    buffer_ >>= count;
    filled_ -= count;
    return value;
  }

  /// Nothing, too, for what put_golomb() never writes.
  std::optional<std::uint32_t> take_golomb(unsigned order) {
    unsigned length = 0;
    for (auto bit = take(1); bit != 0; bit = take(1))
      if (!bit || ++length + order > 31) return std::nullopt;
    const auto high = take(length), low = take(order);
    if (!high || !low) return std::nullopt;
    return ((*high + (1u << length) - 1) << order) | *low;
  }

 private:
  ByteReader& in_;
  std::uint64_t buffer_ = 0;
  unsigned filled_ = 0;
};

}  // namespace fluxgs::codec
