// Quantization of three values a splat whose errors are not all seen alike (noise_shaping.h), such
// as the turn of a disc within its plane, which no image shows.
#pragma once

#include <span>

#include "codec/bytes.h"
#include "codec/channels.h"
#include "codec/quantization.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Rounds to multiples of `step` along the axes of shortest_layout(), and appends a stream for
/// decode_channels(). Errors e of splat i cost eᵀ·H·e: `costs` has the lower triangles of all H,
/// row by row, finite, on any scale. They take the place of the quantization's weights: 1 is the
/// mean of H's diagonals in steps, a part of which is added to each. An error if a value over the
/// step is beyond ±2²⁸.
Expected<void> encode_vectors(const Channels& input, std::span<const float> sensitivity, float step,
                              double rate_weight, Bytes& out);

}  // namespace fluxgs::codec
