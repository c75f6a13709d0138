// Quantization of colours that depend on the direction (noise_shaping.h). Over the few directions
// from which a splat is seen its basis functions are nearly dependent, so that most of what one
// coefficient loses others can make up for. With the Gram matrix G of the functions over those
// directions and 4π·G = L·Lᵀ, errors e of the coefficients cost |Lᵀ·e|² (G is I/4π where a splat is
// seen from all sides: L = I).
#pragma once

#include <span>
#include <vector>

#include "codec/bytes.h"
#include "codec/channels.h"
#include "codec/quantization.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Rounds the coefficients of degrees 1 and up (`rest`, red, green and blue of each) to multiples
/// of `step` and appends them as a stream for decode_channels(). `dc`, three values a splat,
/// becomes what goes best with them. `factors`: L of each splat as in
/// SensitivityWeights::sh_factors, finite, its diagonal above 0. An error if a value over the step
/// is beyond ±2²⁸.
Expected<void> encode_sh(const Channels& rest, std::span<const float> factors, float step,
                         const RateDistortion& rate_distortion, std::vector<float>& dc, Bytes& out);

}  // namespace fluxgs::codec
