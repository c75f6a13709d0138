// An order that keeps neighbours together even in scenes with far splats.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace fluxgs::io {

/// Indices of the positions along a Z-order curve over sign(x)·ln(1 + |x|/r) of each coordinate x
/// about the scene's middle, r being its radius (scene_core.h): the splats of the middle, which are
/// many, get most of the curve's cells.
std::vector<std::uint32_t> spatial_order(const std::vector<glm::vec3>& positions);

}  // namespace fluxgs::io
