// Constants of a scene that every frame needs besides its splats.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "fluxgs/screen_filter.h"

namespace fluxgs::render {

struct SceneConstants {
  std::uint32_t count = 0;  ///< splats
  int sh_degree = 0;        ///< 0…3
  ScreenFilter filter;      ///< to draw it with
  // Of the splats that can be drawn; points at 0 for a scene without any:
  glm::dvec3 origin{0.0};                ///< the median; all other positions are relative to it
  glm::dvec3 lowest{0.0}, highest{0.0};  ///< the box of the positions
};

}  // namespace fluxgs::render
