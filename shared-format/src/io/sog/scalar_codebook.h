// A codebook for single numbers: 256 values, of which each number takes the nearest.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace fluxgs::io {

/// Ascending.
using ScalarCodebook = std::array<float, 256>;

struct WeightedNumber {
  float number;
  float weight;  ///< of its squared error, at least 0
};

/// The codebook with (nearly) the least weighted mean squared error: Lloyd's iteration from centres
/// whose density is that of high-resolution theory, the cube root of the numbers' weights (Panter &
/// Dite 1951). 256 different numbers or less are kept exactly. Without numbers it is zeros.
ScalarCodebook make_scalar_codebook(std::vector<WeightedNumber> numbers);

/// Index of the nearest value.
std::uint8_t nearest_index(const ScalarCodebook& codebook, float number);

}  // namespace fluxgs::io
