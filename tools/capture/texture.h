// Procedural textures: colours as functions of a place.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

namespace fluxgs::capture {

enum class Texture {
  kPlain,
  kCheckerMarble,
  kPlasterStripes,
  kBands,
  kSpeckles,
  kGrass,
  kFoliage,
  kRock,
  kWhitewash,
  kPlanks,   ///< along x, side by side along y
  kPicture,  ///< strong shapes and colours, another picture at each place
  kBricks    ///< in courses along x, one above the other along z; plaster on parts
};

/// The linear RGB colour of a texture at a place; `color` is its main one. `footprint` is the width
/// of a pixel there, in the units of p: the fine textures leave out what is smaller.
glm::vec3 texture_color(Texture texture, const glm::vec3& color, const glm::vec3& p,
                        float footprint, std::uint32_t seed);

}  // namespace fluxgs::capture
