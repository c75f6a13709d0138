// Point clouds in .ply files: sparse points of a data set.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <glm/ext/vector_uint3_sized.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/error.h"

namespace fluxgs {

/// One entry for each vertex, finite or not.
struct PlyPoints {
  std::vector<glm::dvec3> positions;  ///< units of the file
  std::vector<glm::u8vec3> colors;    ///< sRGB; white where the file has none
};

/// Reads the vertices of a .ply (text, or binary of either byte order; Turk 1994): x, y, z, and
/// red, green, blue (0…255, limited to that) where present. Other elements and properties are
/// skipped. Memory: at most 27 bytes for each vertex, of which a file has as many as it has bytes
/// for. Errors name the header's line, or the element and row.
Expected<PlyPoints> read_ply_points(std::span<const std::byte> bytes, const std::string& name);

}  // namespace fluxgs
