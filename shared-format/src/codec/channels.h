// Coding of an attribute with several values for each splat: decorrelated, quantized to a step,
// predicted from the splats before, entropy coded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/bytes.h"
#include "codec/quantization.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Values of `splats`·`channels`, splat by splat. At most 64 channels. `step scale` multiplies the
/// step of each splat (> 0; empty: 1 for all); whoever decodes must have it too.
struct Channels {
  std::size_t channels = 1;
  std::vector<float> values;
  std::vector<float> step_scale = {};

  std::size_t splats() const { return values.size() / channels; }
  double step_scale_of(std::size_t splat) const {
    return step_scale.empty() ? 1.0 : double{step_scale[splat]};
  }
};

/// Appends the values, quantized to multiples of `step` (in the units of the values; > 0) times the
/// splat's step scale around their mean. The channels are turned by the orthogonal Karhunen–Loève
/// transform of their covariance if that takes fewer bits. Rounded to the nearest, a value is off
/// by at most step/2·√channels and its mean square error is about step²/12. Each channel is
/// predicted by the mean of the four splats before where that takes fewer bits; splats should
/// therefore stand in an order that keeps neighbours together. An error if values/step is beyond
/// ±2²⁸ or their mean beyond ±10³⁰.
Expected<void> encode_channels(const Channels& input, float step,
                               const RateDistortion& rate_distortion, Bytes& out);

/// Bits that encode_channels would take, rounding to the nearest, without the few for tables.
Expected<double> channels_bits(const Channels& input, float step);

/// Conversion between the values x of a splat and integers k: x = mean + basis·(step·k).
struct Layout {
  float step = 1;
  std::vector<float> mean = {};
  std::vector<float> basis = {};  ///< channels², orthogonal, column by column; empty: none
  /// Instead of mean and basis: 3², orthogonal, the same for all triples of channels, such as red,
  /// green and blue.
  std::vector<float> axes = {};
  std::vector<std::uint8_t> predicted = {};  ///< 1 for channels of which differences are stored
};

/// The one with which encode_channels would take the fewest bits.
Expected<Layout> shortest_layout(const Channels& input, float step);

/// Appends integers of each channel, or what they differ by from their predictions, as a
/// stream that decode_channels reads.
void encode_whole(const Layout& layout, const std::vector<std::vector<std::int32_t>>& planes,
                  Bytes& out);

/// Reads what encode_channels or encode_whole wrote for `splats` splats of `channels` channels
/// into `values`, already of that size; unlike Channels, these go channel by channel. `step scale`
/// is that of the encoder; where it differs in its last bits, so do the values, and no more.
/// Returns the step, or an error (without a file's name): cut, damaged, another number of channels,
/// or values that are not finite.
Expected<float> decode_channels(ByteReader& in, std::size_t channels,
                                std::span<const float> step_scale, std::span<float> values);

}  // namespace fluxgs::codec
