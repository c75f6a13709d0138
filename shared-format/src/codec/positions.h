// Positions on a grid, coded by Draco's sequential point-cloud encoder in the order given.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "codec/bytes.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Appends the positions, each coordinate quantized to a multiple of `step` (> 0) from the lowest.
/// The order stays; neighbours should be close together. An error if the extent is 2²⁴ steps or
/// more, or if Draco fails.
Expected<void> encode_positions(const std::vector<glm::vec3>& positions, double step, Bytes& out);

/// Reads what encode_positions wrote for positions.size() splats. What Draco is about to read is
/// checked first: its number of points must be that, of one attribute of three 32-bit integers,
/// because its own decoder allocates what its header says. Errors (without a file's name): cut,
/// damaged, another count.
Expected<void> decode_positions(ByteReader& in, std::span<glm::vec3> positions);

}  // namespace fluxgs::codec
