// Positions on a grid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "codec/bytes.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Coding of the cells of the grid: by Draco in files of version 2, in any order.
enum class CellCoding : std::uint8_t { draco, octree };

/// The order in which positions are stored: the Z-order of their cells, order[k] being the index of
/// the k-th. `step` > 0.
std::vector<std::uint32_t> position_order(std::span<const glm::vec3> positions, double step);

/// Appends positions that stand in position_order(), at least one, each coordinate quantized to a
/// multiple of `step` (> 0) from the lowest. An error if the extent is 2²⁴ steps or more.
Expected<void> encode_positions(std::span<const glm::vec3> positions, double step, Bytes& out);

/// Reads what encode_positions wrote for positions.size() splats, or a file of version 2 has.
/// Errors (without a file's name): cut, damaged, another count.
Expected<void> decode_positions(ByteReader& in, CellCoding coding, std::span<glm::vec3> positions);

}  // namespace fluxgs::codec
