// An order that keeps neighbours together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace fluxgs {

/// Indices of the positions along a Z-order curve (Morton 1966) over their bounding cube, 21 bits
/// an axis; ties keep their order. Positions are finite. Takes 24 bytes a position meanwhile.
std::vector<std::uint32_t> morton_order(const std::vector<glm::vec3>& positions);

/// The same of cells of a grid, whose coordinates are 0 to 2²⁴ − 1: by z, y and x of their highest
/// bits, then of the next.
std::vector<std::uint32_t> morton_order(std::span<const glm::ivec3> cells);

}  // namespace fluxgs
