// The entropy coder: two bytes of count, one of channels, then the stream. What can be decoded,
// encoded again, must decode to the same; and so must the stream itself, taken for numbers; all
// within the range of rans.h.
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "codec/rans.h"
#include "fluxgs/byte_reader.h"
#include "harness.h"

namespace fluxgs::fuzz {
namespace {

constexpr std::int32_t kLimit = 1 << 30;

using Numbers = std::vector<std::int32_t>;

Expected<std::vector<Numbers>> decode(ByteReader& in, std::size_t channels, std::size_t count) {
  if (count == 0) return std::vector<Numbers>(channels);
  auto decoder = codec::ValueDecoder::open(in, channels);
  if (!decoder) return std::unexpected(decoder.error());
  std::vector<Numbers> values(channels, Numbers(count));
  for (Numbers& channel : values)
    if (auto ok = decoder->next(channel); !ok) return std::unexpected(ok.error());
  return values;
}

void check_round_trip(const std::vector<Numbers>& channels) {
  for (const Numbers& values : channels)
    if (std::ranges::any_of(values, [](std::int32_t v) { return std::abs(v) >= kLimit; })) return;
  Bytes bytes;
  codec::encode_values(channels, bytes);
  ByteReader in(bytes);
  const auto back = decode(in, channels.size(), channels[0].size());
  require(back.has_value(), "what was encoded can be decoded");
  require(*back == channels && in.left() == 0, "numbers come back as they were");
}

Numbers as_numbers(Input input) {
  Numbers numbers(input.size() / sizeof(std::int32_t));
  if (numbers.empty()) return numbers;
  std::memcpy(numbers.data(), input.data(), numbers.size() * sizeof(std::int32_t));
  for (std::int32_t& number : numbers) number %= kLimit;
  return numbers;
}

}  // namespace

FLUXGS_FUZZ_TARGET(values) {
  Parameters parameters(input);
  const std::size_t count = parameters.word(), channels = parameters.byte() % 4 + 1;
  ByteReader in(parameters.rest());
  const Meter meter;
  const auto decoded = decode(in, channels, count);
  check_memory(meter.peak(), {(256 << 10) + channels * (count << 2), 0}, input.size(), 0);
  if (decoded) {
    check_round_trip(*decoded);
  } else {
    check_error(decoded.error());
    check_round_trip({as_numbers(parameters.rest())});
  }
  return worth_of(channels * count);
}

}  // namespace fluxgs::fuzz
