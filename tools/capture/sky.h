// The sky around a scene: the light of rays that leave it.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

namespace fluxgs::capture {

enum class Sky { kStudio, kClouds };

/// Linear RGB. The studio is a sky over a dark ground, with two softboxes and a window that show in
/// reflections. The seed is that of the clouds.
glm::vec3 sky_light(Sky sky, const glm::vec3& direction, std::uint32_t seed);

}  // namespace fluxgs::capture
