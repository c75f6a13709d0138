#include "codec/rans.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "codec/bits.h"
#include "codec/frequencies.h"
#include "fluxgs/byte_reader.h"

namespace fluxgs::codec {
namespace {

constexpr std::uint32_t kLow = 1u << 16;  // a state is in [2¹⁶, 2³²) between symbols
constexpr std::size_t kStates = 2;        // interleaved: their dependency chains run side by side
constexpr unsigned kMaxRawBits = 24;
constexpr std::int64_t kLimit = std::int64_t{1} << 30;
constexpr unsigned kRawBitsBits = 5, kSymbolsBits = 12, kLowestOrder = 3;  // of a channel's header

using Values = std::span<const std::int32_t>;

std::uint32_t symbol_of(const Split& split, std::int32_t value) {
  return static_cast<std::uint32_t>((value - split.lowest) >> split.raw_bits);
}

std::uint32_t raw_of(const Split& split, std::int32_t value) {
  return static_cast<std::uint32_t>(value - split.lowest) & ((1u << split.raw_bits) - 1);
}

Split split_for(Values values) {
  const auto [low, high] = std::ranges::minmax(values);
  Split split{.lowest = low};
  const std::int64_t range = std::int64_t{high} - low;
  while (static_cast<std::size_t>(range >> split.raw_bits) >= kMaxSymbols) ++split.raw_bits;
  split.symbols = static_cast<std::size_t>(range >> split.raw_bits) + 1;
  return split;
}

std::vector<std::uint32_t> counts_of(Values values, const Split& split) {
  std::vector<std::uint32_t> counts(split.symbols, 0);
  for (const std::int32_t value : values) ++counts[symbol_of(split, value)];
  return counts;
}

std::vector<std::uint32_t> starts_of(const std::vector<std::uint32_t>& frequencies) {
  std::vector<std::uint32_t> starts(frequencies.size());
  std::uint32_t sum = 0;
  for (std::size_t s = 0; s < frequencies.size(); ++s) starts[s] = sum, sum += frequencies[s];
  return starts;
}

/// The words in the order in which the decoder takes them; encoding runs backwards.
class SymbolEncoder {
 public:
  SymbolEncoder() { states_.fill(kLow); }

  /// To be called for the last channel first.
  void add(Values values, const Split& split, const std::vector<std::uint32_t>& frequencies) {
    const std::vector<std::uint32_t> starts = starts_of(frequencies);
    for (std::size_t i = values.size(); i-- > 0;) {
      std::uint32_t& x = states_[i % kStates];
      const std::uint32_t s = symbol_of(split, values[i]), frequency = frequencies[s];
      if (x >= (std::uint64_t{frequency} << (32 - kScaleBits))) {
        words_.push_back(static_cast<std::uint16_t>(x));
        x >>= 16;
      }
      x = ((x / frequency) << kScaleBits) + x % frequency + starts[s];
    }
  }

  void finish(Bytes& out) {
    for (const std::uint32_t x : states_) put(out, x);
    put_varint(out, words_.size());
    std::ranges::reverse(words_);
    for (const std::uint16_t word : words_) put(out, word);
  }

 private:
  std::array<std::uint32_t, kStates> states_;
  std::vector<std::uint16_t> words_;
};

void put_raw_bits(Values values, const Split& split, Bytes& out) {
  BitWriter bits(out);
  for (const std::int32_t value : values) bits.put(raw_of(split, value), split.raw_bits);
  bits.finish();
}

/// Decoding of one channel. A table of slots with all that is known of a symbol would not fit into
/// the first cache; one of symbols does.
class SymbolTable {
 public:
  explicit SymbolTable(const std::vector<std::uint32_t>& frequencies)
      : intervals_(frequencies.size()) {
    std::uint32_t start = 0;
    for (std::size_t s = 0; s < frequencies.size(); ++s) {
      intervals_[s] = {static_cast<std::uint16_t>(start),
                       static_cast<std::uint16_t>(frequencies[s])};
      std::fill_n(symbols_.begin() + start, frequencies[s], static_cast<std::uint16_t>(s));
      start += frequencies[s];
    }
  }

  /// The symbol of a state, which moves on, except for the word that it may need.
  std::int32_t take(std::uint32_t& x) const {
    const std::uint32_t slot = x % kFrequencySum, symbol = symbols_[slot];
    const Interval& interval = intervals_[symbol];
    x = interval.frequency * (x >> kScaleBits) + (slot - interval.start);
    return static_cast<std::int32_t>(symbol);
  }

 private:
  struct Interval {
    std::uint16_t start, frequency;
  };
  std::array<std::uint16_t, kFrequencySum> symbols_;
  std::vector<Interval> intervals_;
};

/// Words on their way into the states.
class CodedWords {
 public:
  explicit CodedWords(std::span<const std::byte> words)
      : at_(words.data()), end_(words.data() + words.size()) {}

  std::size_t left() const { return static_cast<std::size_t>(end_ - at_) / sizeof(std::uint16_t); }

  /// Gives the state a word if it needs one. Precondition: one is left. Without a branch, which
  /// processors would often foresee wrongly.
  void refill(std::uint32_t& x) {
    std::uint16_t next;
    std::memcpy(&next, at_, sizeof next);
    const std::uint32_t needs = x < kLow ? 1 : 0;
    x = (x << (16 * needs)) | (next & (0 - needs));
    at_ += needs * sizeof next;
  }

 private:
  const std::byte *at_, *end_;
};

std::unexpected<Error> damaged(const char* what) { return fail("", "", what); }

Expected<Split> take_split(BitReader& in) {
  const auto lowest = in.take_golomb(kLowestOrder);
  const auto raw_bits = in.take(kRawBitsBits), symbols = in.take(kSymbolsBits);
  if (!lowest || !raw_bits || !symbols) return damaged("the header of a channel is cut off");
  const Split split{.lowest = unzigzag(*lowest), .raw_bits = *raw_bits, .symbols = *symbols + 1};
  const bool sound = split.lowest > -kLimit && split.lowest < kLimit &&
                     split.raw_bits <= kMaxRawBits &&
                     split.lowest + (std::int64_t{*symbols} << split.raw_bits) < kLimit;
  if (!sound) return damaged("the range of a channel is not one that this codec writes");
  return split;
}

void put_split(const Split& split, BitWriter& out) {
  out.put_golomb(static_cast<std::uint32_t>(zigzag(split.lowest)), kLowestOrder);
  out.put(split.raw_bits, kRawBitsBits);
  out.put(split.symbols - 1, kSymbolsBits);
}

void add_lowest(std::int64_t lowest, std::span<std::int32_t> values) {
  for (std::int32_t& value : values) value += static_cast<std::int32_t>(lowest);
}

void add_raw_bits(std::span<const std::byte> raw, const Split& split,
                  std::span<std::int32_t> values) {
  ByteReader in(raw);
  BitReader bits(in);
  for (std::int32_t& value : values)
    value = static_cast<std::int32_t>(split.lowest + (std::int64_t{value} << split.raw_bits) +
                                      *bits.take(split.raw_bits));
}

}  // namespace

void encode_values(std::span<const std::vector<std::int32_t>> channels, Bytes& out) {
  if (channels.empty() || channels[0].empty()) return;
  std::vector<Split> splits;
  std::vector<std::vector<std::uint32_t>> frequencies(channels.size());
  BitWriter bits(out);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    splits.push_back(split_for(channels[c]));
    put_split(splits[c], bits);
    if (splits[c].symbols > 1)
      frequencies[c] = put_frequencies(counts_of(channels[c], splits[c]), bits);
  }
  bits.finish();
  SymbolEncoder symbols;
  for (std::size_t c = channels.size(); c-- > 0;)
    if (splits[c].symbols > 1) symbols.add(channels[c], splits[c], frequencies[c]);
  symbols.finish(out);
  for (std::size_t c = 0; c < channels.size(); ++c)
    if (splits[c].raw_bits > 0) put_raw_bits(channels[c], splits[c], out);
}

double entropy_bits(Values values) {
  if (values.empty()) return 0;
  const Split split = split_for(values);
  const double total = static_cast<double>(values.size());
  double bits = total * split.raw_bits;
  for (const std::uint32_t count : counts_of(values, split))
    if (count > 0) bits += count * std::log2(total / count);
  return bits;
}

Expected<ValueDecoder> ValueDecoder::open(ByteReader& in, std::size_t channels) {
  ValueDecoder decoder(in);
  decoder.channels_.resize(channels);
  BitReader bits(in);
  for (Channel& channel : decoder.channels_) {
    const auto split = take_split(bits);
    if (!split) return std::unexpected(split.error());
    channel.split = *split;
    if (split->symbols == 1) continue;
    auto frequencies = take_frequencies(bits, split->symbols);
    if (!frequencies) return std::unexpected(frequencies.error());
    channel.frequencies = std::move(*frequencies);
  }
  for (std::uint32_t& x : decoder.states_) {
    const auto state = in.take<std::uint32_t>();
    if (!state || *state < kLow) return damaged("the coded values are cut off or damaged");
    x = *state;
  }
  const auto words = in.take_varint();
  if (!words || *words > in.left() / 2) return damaged("the coded values are cut off");
  decoder.words_ = *in.take_bytes(2 * *words);
  return decoder;
}

Expected<void> ValueDecoder::decode_symbols(const Channel& channel,
                                            std::span<std::int32_t> values) {
  const SymbolTable table(channel.frequencies);
  CodedWords words(words_);
  std::array<std::uint32_t, kStates> states = states_;
  for (std::size_t i = 0; i < values.size();) {
    // A symbol takes a word at most
    const std::size_t safe = i + std::min(values.size() - i, words.left()) / kStates * kStates;
    for (; i < safe; i += kStates)
      for (std::size_t k = 0; k < kStates; ++k) {
        values[i + k] = table.take(states[k]);
        words.refill(states[k]);
      }
    // A few, near the end of the words or of the values
    for (std::size_t k = 0; k < kStates && i < values.size(); ++k, ++i) {
      values[i] = table.take(states[k]);
      if (states[k] >= kLow) continue;
      if (words.left() == 0) return damaged("the coded values are cut off or damaged");
      words.refill(states[k]);
    }
  }
  words_ = words_.last(sizeof(std::uint16_t) * words.left());
  states_ = states;
  return {};
}

/// A stream that was read right ends where the encoder began.
bool ValueDecoder::is_sound_at_the_end() const {
  return words_.empty() && std::ranges::all_of(states_, [](auto x) { return x == kLow; });
}

Expected<void> ValueDecoder::next(std::span<std::int32_t> values) {
  const Channel& channel = channels_[next_++];
  if (channel.frequencies.empty())
    std::ranges::fill(values, 0);
  else if (auto ok = decode_symbols(channel, values); !ok)
    return ok;
  if (channel.split.raw_bits == 0) {
    add_lowest(channel.split.lowest, values);
  } else {
    const auto raw =
        in_->take_bytes((std::uint64_t{values.size()} * channel.split.raw_bits + 7) / 8);
    if (!raw) return damaged("the uncoded bits of the values are cut off");
    add_raw_bits(*raw, channel.split, values);
  }
  if (next_ == channels_.size() && !is_sound_at_the_end())
    return damaged("the coded values are damaged");
  return {};
}

}  // namespace fluxgs::codec
