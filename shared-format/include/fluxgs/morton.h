// An order that keeps neighbours together.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace fluxgs {

/// Indices of the positions along a Z-order curve (Morton 1966) over their bounding cube, 21 bits
/// an axis; ties keep their order. Positions are finite. Takes 24 bytes a position meanwhile.
std::vector<std::uint32_t> morton_order(const std::vector<glm::vec3>& positions);

}  // namespace fluxgs
