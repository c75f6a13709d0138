// Light: what surfaces make of the lamps and of all that is around them.
#pragma once

#include <glm/vec3.hpp>

#include "tools/capture/scene.h"

namespace fluxgs::capture {

/// The light along a ray, linear RGB ≥ 0. Mirror reflections are followed `bounces` times.
glm::vec3 radiance(const Scene& scene, const glm::vec3& origin, const glm::vec3& direction,
                   int bounces);

/// Maps light to a display's linear range 0…1: highlights roll off instead of being cut.
glm::vec3 tone_map(const glm::vec3& light);

/// The sRGB transfer function (IEC 61966-2-1) on 0…1.
float srgb_encode(float linear);

}  // namespace fluxgs::capture
