// Cells of a grid as an octree: level by level, which of a node's eight children are there.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "codec/bytes.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

using Cell = glm::ivec3;

/// Coordinates of cells have so many bits at most.
inline constexpr unsigned kOctreeLevels = 24;

/// Appends cells, at least one, which stand in their Z-order (fluxgs/morton.h) and may be equal.
/// Coordinates are 0 to 2²⁴ − 1.
void encode_octree(std::span<const Cell> cells, Bytes& out);

/// Reads what encode_octree wrote for cells.size() of them, at least one. Errors (without a file's
/// name): cut, damaged, another number of cells. Takes 4 bytes a cell meanwhile, and tables.
Expected<void> decode_octree(ByteReader& in, std::span<Cell> cells);

}  // namespace fluxgs::codec
