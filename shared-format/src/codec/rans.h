// Entropy coding of integers: range asymmetric numeral systems (Duda 2013, "Asymmetric numeral
// systems: entropy coding combining speed of Huffman coding with compression rate of arithmetic
// coding") with one static table of frequencies for each channel of values.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/bytes.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Appends channels, each of a value or more, to `out`, in about as many bits as their entropy
/// says, plus a table of some three bits for each distinct value. Values of a channel that spread
/// over more than 4,096 neighbours keep their low bits uncoded (bypass bits). |value| < 2³⁰.
void encode_values(std::span<const std::vector<std::int32_t>> channels, Bytes& out);

/// Bits that encode_values would take for the values themselves (their empirical entropy).
double entropy_bits(std::span<const std::int32_t> values);

/// Split of a value: symbol = (value − lowest) >> raw_bits, the rest is stored as it is.
struct Split {
  std::int64_t lowest = 0;
  unsigned raw_bits = 0;
  std::size_t symbols = 1;
};

/// Decodes what encode_values() has written, channel by channel. Errors (without a file's name):
/// the stream is cut, a table is none, or it is damaged.
class ValueDecoder {
 public:
  /// Takes a stream of so many channels, at least one, off the reader, which must outlive the
  /// decoder and stand behind the stream once all channels are decoded. At most kMaxSymbols values
  /// are kept of each channel.
  static Expected<ValueDecoder> open(ByteReader& in, std::size_t channels);

  /// The next channel, whole. Precondition: there is one, and `values` has room for its values, at
  /// least one.
  Expected<void> next(std::span<std::int32_t> values);

 private:
  struct Channel {
    Split split;
    std::vector<std::uint32_t> frequencies;  // none where there is one symbol only
  };
  static constexpr std::size_t kStates = 2;

  explicit ValueDecoder(ByteReader& in) : in_(&in) {}
  Expected<void> decode_symbols(const Channel& channel, std::span<std::int32_t> values);
  bool is_sound_at_the_end() const;

  ByteReader* in_;  // the raw parts are next
  std::vector<Channel> channels_;
  std::size_t next_ = 0;
  std::array<std::uint32_t, kStates> states_{};
  std::span<const std::byte> words_;
};

}  // namespace fluxgs::codec
