// The entropy coder: two bytes of count, then the stream. What can be decoded, encoded again, must
// decode to the same; and so must the stream itself, taken for numbers; all within the range of
// rans.h.
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "codec/rans.h"
#include "harness.h"

namespace fluxgs::fuzz {
namespace {

constexpr std::int32_t kLimit = 1 << 30;

void check_round_trip(const std::vector<std::int32_t>& values) {
  if (std::ranges::any_of(values, [](std::int32_t v) { return std::abs(v) >= kLimit; })) return;
  Bytes bytes;
  codec::encode_values(values, bytes);
  std::vector<std::int32_t> back(values.size());
  codec::Reader in(bytes);
  require(codec::decode_values(in, back).has_value(), "what was encoded can be decoded");
  require(back == values && in.left() == 0, "numbers come back as they were");
}

std::vector<std::int32_t> as_numbers(Input input) {
  std::vector<std::int32_t> numbers(input.size() / sizeof(std::int32_t));
  if (numbers.empty()) return numbers;
  std::memcpy(numbers.data(), input.data(), numbers.size() * sizeof(std::int32_t));
  for (std::int32_t& number : numbers) number %= kLimit;
  return numbers;
}

}  // namespace

FLUXGS_FUZZ_TARGET(values) {
  Parameters parameters(input);
  std::vector<std::int32_t> values(parameters.word());
  codec::Reader in(parameters.rest());
  const Meter meter;
  const auto decoded = codec::decode_values(in, values);
  check_memory(meter.peak(), {256 << 10, 0}, input.size(), 0);
  if (decoded) {
    check_round_trip(values);
  } else {
    check_error(decoded.error());
    check_round_trip(as_numbers(parameters.rest()));
  }
  return worth_of(values.size());
}

}  // namespace fluxgs::fuzz
