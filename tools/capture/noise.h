// Noise: random functions of a place that are the same wherever and whenever they are asked.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

namespace fluxgs::capture {

/// A number between 0 and 1 for a point of the integer grid.
float grid_noise(int x, int y, int z, std::uint32_t seed);

/// Smooth noise of unit wavelength between 0 and 1.
float value_noise(const glm::vec3& p, std::uint32_t seed);

/// Several octaves of value_noise, each of half the wavelength and half the weight; 0…1.
float fractal_noise(const glm::vec3& p, int octaves, std::uint32_t seed);

/// Octaves of value_noise as a camera shows them: each of half the wavelength and `gain` times the
/// weight of the one before, without those that are finer than a pixel, which is `footprint` wide
/// at p. Without these, far textures would flicker from view to view. 0…1, 0.5 on average.
float detail_noise(const glm::vec3& p, int octaves, float gain, float footprint,
                   std::uint32_t seed);

/// The largest integer ≤ x. std::floor is a library call on processors without SSE 4.1.
int floor_to_int(float x);

}  // namespace fluxgs::capture
