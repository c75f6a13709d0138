// Entropy coding of whole numbers: range asymmetric numeral systems (Duda 2013, "Asymmetric numeral
// systems: entropy coding combining speed of Huffman coding with compression rate of arithmetic
// coding") with one static table of frequencies for each stream.
#pragma once

#include <cstdint>
#include <span>

#include "codec/bytes.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Appends `values` to `out` in about as many bits as their entropy says, plus a table of one or
/// two bytes for each distinct value. Values that spread over more than 4,096 neighbours keep their
/// low bits uncoded (bypass bits). |value| < 2³⁰.
void encode_values(std::span<const std::int32_t> values, Bytes& out);

/// Bits that encode_values would take for the values themselves (their empirical entropy).
double entropy_bits(std::span<const std::int32_t> values);

/// Fills `values`, whose size the caller knows. Nothing is allocated beyond a table of fixed size.
/// Errors (without a file's name): the stream is cut, its table is not one, or it is damaged.
Expected<void> decode_values(Reader& in, std::span<std::int32_t> values);

}  // namespace fluxgs::codec
