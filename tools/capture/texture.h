// Procedural textures: colours as functions of a place.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

namespace fluxgs::capture {

/// Smooth noise of unit wavelength between 0 and 1.
float value_noise(const glm::vec3& p, std::uint32_t seed);

/// Several octaves of value_noise, each of half the wavelength and half the weight; 0…1.
float fractal_noise(const glm::vec3& p, int octaves, std::uint32_t seed);

enum class Texture { kPlain, kCheckerMarble, kPlasterStripes, kBands, kSpeckles };

/// The linear RGB colour of a texture at a place; `color` is its main one.
glm::vec3 texture_color(Texture texture, const glm::vec3& color, const glm::vec3& p,
                        std::uint32_t seed);

}  // namespace fluxgs::capture
