// Symbol frequencies in few bits, as exactly as it pays.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/bits.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

inline constexpr unsigned kScaleBits = 14;
inline constexpr std::uint32_t kFrequencySum = 1u << kScaleBits;
inline constexpr std::size_t kMaxSymbols = 4096;

/// Frequencies that sum to kFrequencySum, for coding symbols that occur so often: at least 1 for
/// each that does. Two symbols or more occur, of at most kMaxSymbols.
///
/// What is stored are weights with a mantissa of few bits, in proportion to the counts. Of the
/// exactnesses it takes the one with which table and symbols together are shortest.
std::vector<std::uint32_t> put_frequencies(std::span<const std::uint32_t> counts, BitWriter& out);

/// Reads the table that put_frequencies() wrote, of so many symbols. Errors: the table is cut off
/// or is none.
Expected<std::vector<std::uint32_t>> take_frequencies(BitReader& in, std::size_t symbols);

}  // namespace fluxgs::codec
