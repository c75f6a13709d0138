// An attribute of the compact codec: two bytes of count, one of channels, one of flags (do the
// splats differ in step scale, are they rounded cheaply), then the stream. What can be decoded must
// encode again to within the error that channels.h states, or be refused.
#include "codec/channels.h"

#include <algorithm>
#include <cmath>

#include "fluxgs/byte_reader.h"
#include "harness.h"

namespace fluxgs::fuzz {
namespace {

std::vector<float> some_step_scale(std::size_t splats) {
  std::vector<float> step_scale(splats);
  for (std::size_t i = 0; i < splats; ++i) {
    step_scale[i] = 0.25f * static_cast<float>(1 + i * 7 % 16);
  }
  return step_scale;
}

void check_round_trip(const codec::Channels& input, const codec::RateDistortion& how) {
  constexpr float kStep = 0.125f;
  Bytes bytes;
  const auto encoded = codec::encode_channels(input, kStep, how, bytes);
  if (!encoded) return check_error(encoded.error());
  std::vector<float> back(input.values.size());
  ByteReader in(bytes);
  const auto decoded = codec::decode_channels(in, input.channels, input.step_scale, back);
  if (!decoded) broken("what was encoded can be decoded: " + decoded.error().message());
  require(in.left() == 0, "nothing is left over");
  const float steps = how.rate_weight > 0 ? 1.5f : 0.5f;  // quantization.h
  float largest = 0;
  for (const float value : input.values) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < back.size(); ++i) {
    const std::size_t splat = i % input.splats(), channel = i / input.splats();
    const float before = input.values[splat * input.channels + channel];
    const float step_scale = input.step_scale.empty() ? 1 : input.step_scale[splat];
    const float channels = static_cast<float>(input.channels);
    // Single precision: the mean and the axes are stored in it, sums over channels done in it.
    const float float_error = 1e-5f * channels * largest;
    require(std::abs(back[i] - before) <=
                kStep * step_scale * steps * std::sqrt(channels) * 1.001f + float_error,
            "a value is off by at most as many steps as its rounding says");
  }
}

}  // namespace

FLUXGS_FUZZ_TARGET(channels) {
  Parameters parameters(input);
  const std::size_t splats = parameters.word() % 4096, channels = parameters.byte();
  const std::uint8_t flags = parameters.byte();
  const bool coarse = flags % 2 != 0, cheaply = flags / 2 % 2 != 0;
  codec::Channels output{std::max<std::size_t>(channels, 1), std::vector<float>(splats * channels),
                         coarse ? some_step_scale(splats) : std::vector<float>()};
  ByteReader in(parameters.rest());
  const Meter meter;
  const auto decoded = codec::decode_channels(in, channels, output.step_scale, output.values);
  check_memory(meter.peak(), {256 << 10, 0}, input.size(), 2 * splats);
  if (!decoded) {
    check_error(decoded.error());
    return Worth::keep;
  }
  require(std::ranges::all_of(output.values, [](float v) { return std::isfinite(v); }),
          "values are finite");
  if (splats > 0) check_round_trip(output, {.rate_weight = cheaply ? 0.5 : 0.0});
  return Worth::keep;
}

}  // namespace fluxgs::fuzz
