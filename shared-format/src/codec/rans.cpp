#include "codec/rans.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>

namespace fluxgs::codec {
namespace {

constexpr unsigned kScaleBits = 14;
constexpr std::uint32_t kScale = 1u << kScaleBits;
constexpr std::uint32_t kLow = 1u << 16;  // a state is in [2¹⁶, 2³²) between symbols
constexpr std::size_t kMostSymbols = 4096;
constexpr std::size_t kStates = 2;  // interleaved: their dependency chains run side by side
constexpr unsigned kMostRawBits = 24;
constexpr std::int64_t kLimit = std::int64_t{1} << 30;

/// How values are split: symbol = (value − lowest) >> raw_bits, the rest is stored as it is.
struct Split {
  std::int64_t lowest = 0;
  unsigned raw_bits = 0;
  std::size_t symbols = 1;

  std::uint32_t symbol(std::int32_t value) const {
    return static_cast<std::uint32_t>((value - lowest) >> raw_bits);
  }
  std::uint32_t raw(std::int32_t value) const {
    return static_cast<std::uint32_t>(value - lowest) & ((1u << raw_bits) - 1);
  }
};

Split split_for(std::span<const std::int32_t> values) {
  const auto [low, high] = std::ranges::minmax(values);
  Split split{.lowest = low};
  const std::int64_t range = std::int64_t{high} - low;
  while (static_cast<std::size_t>(range >> split.raw_bits) >= kMostSymbols) ++split.raw_bits;
  split.symbols = static_cast<std::size_t>(range >> split.raw_bits) + 1;
  return split;
}

/// Frequencies that sum to kScale, at least 1 for each symbol that occurs.
std::vector<std::uint32_t> scaled_frequencies(const std::vector<std::uint64_t>& counts,
                                              std::uint64_t total) {
  std::vector<std::uint32_t> scaled(counts.size(), 0);
  std::int64_t left = kScale;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (counts[s] == 0) continue;
    scaled[s] = std::max<std::uint32_t>(
        1, static_cast<std::uint32_t>(counts[s] * std::uint64_t{kScale} / total));
    left -= scaled[s];
  }
  // What rounding left over or overspent is taken where it costs least: at the largest
  while (left != 0) {
    const auto largest = std::ranges::max_element(scaled);
    const std::int64_t step = left > 0 ? left : -std::min<std::int64_t>(-left, (*largest - 1) / 2);
    *largest = static_cast<std::uint32_t>(*largest + step);
    left -= step;
  }
  return scaled;
}

/// Runs of zeros as 0 and their length, others as they are.
void put_frequencies(const std::vector<std::uint32_t>& scaled, Bytes& out) {
  for (std::size_t s = 0; s < scaled.size();) {
    put_varint(out, scaled[s]);
    std::size_t next = s + 1;
    if (scaled[s] == 0) {
      while (next < scaled.size() && scaled[next] == 0) ++next;
      put_varint(out, next - s);
    }
    s = next;
  }
}

std::vector<std::uint32_t> starts_of(const std::vector<std::uint32_t>& scaled) {
  std::vector<std::uint32_t> starts(scaled.size());
  std::uint32_t sum = 0;
  for (std::size_t s = 0; s < scaled.size(); ++s) starts[s] = sum, sum += scaled[s];
  return starts;
}

/// The words in the order in which the decoder takes them; encoding runs backwards.
std::vector<std::uint16_t> encode_symbols(std::span<const std::int32_t> values, const Split& split,
                                          const std::vector<std::uint32_t>& scaled,
                                          std::array<std::uint32_t, kStates>& states) {
  const std::vector<std::uint32_t> starts = starts_of(scaled);
  std::vector<std::uint16_t> words;
  states.fill(kLow);
  for (std::size_t i = values.size(); i-- > 0;) {
    std::uint32_t& x = states[i % kStates];
    const std::uint32_t s = split.symbol(values[i]), frequency = scaled[s];
    if (x >= (std::uint64_t{frequency} << (32 - kScaleBits))) {
      words.push_back(static_cast<std::uint16_t>(x));
      x >>= 16;
    }
    x = ((x / frequency) << kScaleBits) + x % frequency + starts[s];
  }
  std::ranges::reverse(words);
  return words;
}

void put_raw_bits(std::span<const std::int32_t> values, const Split& split, Bytes& out) {
  std::uint64_t buffer = 0;
  unsigned filled = 0;
  for (const std::int32_t value : values) {
    buffer |= std::uint64_t{split.raw(value)} << filled;
    for (filled += split.raw_bits; filled >= 8; filled -= 8, buffer >>= 8)
      out.push_back(static_cast<std::byte>(buffer));
  }
  if (filled > 0) out.push_back(static_cast<std::byte>(buffer));
}

struct Slot {
  std::uint16_t symbol, frequency, offset;  // offset: position inside the symbol's interval
};
using Table = std::array<Slot, kScale>;

std::unexpected<Error> damaged(const char* what) { return fail("", "", what); }

Expected<Split> take_split(Reader& in) {
  const auto lowest = in.take_varint(), raw_bits = in.take_varint(), symbols = in.take_varint();
  if (!lowest || !raw_bits || !symbols) return damaged("the coded values are cut off");
  const Split split{.lowest = unzigzag(*lowest),
                    .raw_bits = static_cast<unsigned>(std::min<std::uint64_t>(*raw_bits, 64)),
                    .symbols = static_cast<std::size_t>(*symbols)};
  const bool sound =
      split.lowest > -kLimit && split.lowest < kLimit && *raw_bits <= kMostRawBits &&
      *symbols >= 1 && *symbols <= kMostSymbols &&
      split.lowest + (static_cast<std::int64_t>(*symbols - 1) << split.raw_bits) < kLimit;
  if (!sound) return damaged("the range of the coded values is not one that this codec writes");
  return split;
}

Expected<void> take_table(Reader& in, std::size_t symbols, Table& table) {
  std::size_t filled = 0;
  for (std::size_t s = 0; s < symbols;) {
    const auto frequency = in.take_varint();
    if (!frequency) return damaged("the table of frequencies is cut off");
    if (*frequency == 0) {
      const auto run = in.take_varint();
      if (!run || *run == 0 || *run > symbols - s)
        return damaged("the table of frequencies has a run of zeros that does not fit");
      s += static_cast<std::size_t>(*run);
      continue;
    }
    if (*frequency >= kScale || *frequency > kScale - filled)
      return damaged("the frequencies sum to more than 16384");
    for (std::uint16_t k = 0; k < *frequency; ++k)
      table[filled++] = {static_cast<std::uint16_t>(s), static_cast<std::uint16_t>(*frequency), k};
    ++s;
  }
  if (filled != kScale) return damaged("the frequencies sum to less than 16384");
  return {};
}

Expected<void> decode_symbols(Reader& in, const Split& split, std::span<std::int32_t> values) {
  const auto table = std::make_unique<Table>();
  if (auto ok = take_table(in, split.symbols, *table); !ok) return ok;
  std::array<std::uint32_t, kStates> states;
  for (std::uint32_t& x : states) {
    const auto state = in.take<std::uint32_t>();
    if (!state || *state < kLow) return damaged("the coded values are cut off or damaged");
    x = *state;
  }
  const auto count = in.take_varint();
  if (!count || *count > in.left() / 2) return damaged("the coded values are cut off");
  const std::byte* word = in.take_bytes(2 * *count)->data();
  const std::byte* const end = word + 2 * *count;
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint32_t& x = states[i % kStates];
    const Slot& slot = (*table)[x % kScale];
    x = slot.frequency * (x >> kScaleBits) + slot.offset;
    if (x < kLow) {
      if (word == end) return damaged("the coded values are cut off or damaged");
      std::uint16_t next;
      std::memcpy(&next, word, sizeof next);
      word += sizeof next;
      x = (x << 16) | next;
    }
    values[i] = slot.symbol;
  }
  // A stream that was read right ends where the encoder began
  if (word != end || std::ranges::any_of(states, [](auto x) { return x != kLow; }))
    return damaged("the coded values are damaged");
  return {};
}

Expected<void> add_raw_bits(Reader& in, const Split& split, std::span<std::int32_t> values) {
  const std::uint64_t bits = std::uint64_t{values.size()} * split.raw_bits;
  const auto bytes = in.take_bytes((bits + 7) / 8);
  if (!bytes) return damaged("the uncoded bits of the values are cut off");
  std::uint64_t buffer = 0;
  unsigned filled = 0;
  std::size_t next = 0;
  for (std::int32_t& value : values) {
    for (; filled < split.raw_bits; filled += 8)
      buffer |= std::to_integer<std::uint64_t>((*bytes)[next++]) << filled;
    const auto raw = static_cast<std::int64_t>(buffer & ((1u << split.raw_bits) - 1));
    buffer >>= split.raw_bits;
    filled -= split.raw_bits;
    value = static_cast<std::int32_t>(split.lowest + (std::int64_t{value} << split.raw_bits) + raw);
  }
  return {};
}

}  // namespace

void encode_values(std::span<const std::int32_t> values, Bytes& out) {
  if (values.empty()) return;
  const Split split = split_for(values);
  put_varint(out, zigzag(split.lowest));
  put_varint(out, split.raw_bits);
  put_varint(out, split.symbols);
  if (split.symbols > 1) {
    std::vector<std::uint64_t> counts(split.symbols, 0);
    for (const std::int32_t value : values) ++counts[split.symbol(value)];
    const auto scaled = scaled_frequencies(counts, values.size());
    put_frequencies(scaled, out);
    std::array<std::uint32_t, kStates> states;
    const auto words = encode_symbols(values, split, scaled, states);
    for (const std::uint32_t x : states) put(out, x);
    put_varint(out, words.size());
    for (const std::uint16_t word : words) put(out, word);
  }
  if (split.raw_bits > 0) put_raw_bits(values, split, out);
}

double entropy_bits(std::span<const std::int32_t> values) {
  if (values.empty()) return 0;
  const Split split = split_for(values);
  std::vector<std::uint32_t> counts(split.symbols, 0);
  for (const std::int32_t value : values) ++counts[split.symbol(value)];
  const double total = static_cast<double>(values.size());
  double bits = total * split.raw_bits;
  for (const std::uint32_t count : counts)
    if (count > 0) bits += count * std::log2(total / count);
  return bits;
}

Expected<void> decode_values(Reader& in, std::span<std::int32_t> values) {
  if (values.empty()) return {};
  const auto split = take_split(in);
  if (!split) return std::unexpected(split.error());
  if (split->symbols == 1)
    std::ranges::fill(values, 0);
  else if (auto ok = decode_symbols(in, *split, values); !ok)
    return ok;
  return add_raw_bits(in, *split, values);
}

}  // namespace fluxgs::codec
