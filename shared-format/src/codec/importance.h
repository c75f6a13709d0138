// How exactly each splat is worth storing, told from attributes that are decoded before.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace fluxgs::codec {

/// Coarseness (channels.h) of the rotation. The more its scales differ, the more a turn changes a
/// splat, and the larger it is, the more pixels it changes.
std::vector<float> rotation_coarseness(std::span<const glm::vec3> log_scales);

/// Coarseness of the colour: smaller for splats that cover more, by area times opacity.
std::vector<float> color_coarseness(std::span<const glm::vec3> log_scales,
                                    std::span<const float> opacity_logits);

}  // namespace fluxgs::codec
