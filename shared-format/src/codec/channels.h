// Coding of an attribute with several numbers for each splat: decorrelated, rounded to a step,
// predicted from the splats before, entropy coded.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/bytes.h"
#include "codec/rounding.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Numbers of `splats`·`channels`, splat by splat. At most 64 channels. `coarseness` multiplies the
/// step of each splat (> 0; empty: 1 for all); whoever decodes must have it too.
struct Channels {
  std::size_t channels = 1;
  std::vector<float> values;
  std::vector<float> coarseness = {};

  std::size_t splats() const { return values.size() / channels; }
};

/// Appends the values, rounded to multiples of `step` (in the units of the values; > 0) times the
/// splat's coarseness around their mean. The channels are turned by the orthogonal Karhunen–Loève
/// transform of their covariance if that takes fewer bits. Rounded to the nearest, a value is off
/// by at most step/2·√channels and its mean square error is about step²/12. Each channel is
/// predicted by the mean of the four splats before where that takes fewer bits; splats should
/// therefore stand in an order that keeps neighbours together. An error if values/step is beyond
/// ±2²⁸ or their mean beyond ±10³⁰.
Expected<void> encode_channels(const Channels& input, float step, const Rounding& rounding,
                               Bytes& out);

/// Bits that encode_channels would take, rounding to the nearest, without the few for tables.
Expected<double> channels_bits(const Channels& input, float step);

/// Numbers of three channels that belong together, such as red, green and blue: turned by an
/// orthogonal matrix, column by column, and already whole.
struct Triples {
  std::array<float, 9> axes = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<std::vector<std::int32_t>> planes = {};  ///< multiples of the step, by channel
};

/// Appends them as a stream that decode_channels reads, with a mean of zero.
void encode_triples(const Triples& triples, float step, Bytes& out);

/// Reads what encode_channels or encode_triples wrote for `splats` splats of `channels` channels
/// into `values`, already of that size; unlike Channels, these go channel by channel. `coarseness`
/// is that of the encoder; where it differs in its last bits, so do the values, and no more.
/// Returns the step, or an error (without a file's name): cut, damaged, another number of channels,
/// or numbers that are not finite.
Expected<float> decode_channels(Reader& in, std::size_t channels, std::span<const float> coarseness,
                                std::span<float> values);

}  // namespace fluxgs::codec
