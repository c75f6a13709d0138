#include "tools/capture/texture.h"

#include <cmath>
#include <initializer_list>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace fluxgs::capture {
namespace {

/// A number between 0 and 1 for a point of the integer grid (a multiply–xorshift hash).
float lattice(int x, int y, int z, std::uint32_t seed) {
  std::uint32_t h = seed;
  for (const int c : {x, y, z}) {
    h = (h ^ static_cast<std::uint32_t>(c)) * 0x9e3779b1U;
    h ^= h >> 15;
  }
  h *= 0x85ebca77U;
  return static_cast<float>((h ^ h >> 13) >> 8) * 0x1p-24F;
}

/// The largest integer ≤ x. std::floor is a library call on processors without SSE 4.1.
int floor_to_int(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

/// True if the floor of x is odd.
bool is_odd(float x) { return (floor_to_int(x) & 1) != 0; }

glm::vec3 checker_marble(const glm::vec3& color, const glm::vec3& p, std::uint32_t seed) {
  const float veins = std::abs(std::sin(5 * p.x + 3 * p.y + 7 * fractal_noise(2.0F * p, 4, seed)));
  const glm::vec3 dark(0.035F, 0.05F, 0.075F);
  const bool light = is_odd(p.x / 0.6F) != is_odd(p.y / 0.6F);
  return light ? color * (0.55F + 0.45F * std::pow(veins, 0.4F))
               : dark + 0.07F * std::pow(1 - veins, 6.0F);
}

glm::vec3 plaster_stripes(const glm::vec3& color, const glm::vec3& p, std::uint32_t seed) {
  const float grain = fractal_noise(6.0F * p, 4, seed);
  const float blotches = fractal_noise(1.3F * p, 2, seed + 1);
  const glm::vec3 second(0.62F, 0.50F, 0.36F);
  const glm::vec3 stripe = is_odd((p.x + 0.12F * p.z) / 0.42F) ? color : second;
  return stripe * (0.45F + 0.5F * grain + 0.3F * blotches);
}

glm::vec3 bands(const glm::vec3& color, const glm::vec3& p) {
  const glm::vec3 axis = glm::normalize(glm::vec3(0.3F, -0.5F, 0.8F));
  return is_odd(glm::dot(p, axis) / 0.11F) ? color : glm::vec3(0.82F, 0.80F, 0.74F);
}

glm::vec3 speckles(const glm::vec3& color, const glm::vec3& p, std::uint32_t seed) {
  const float spots = glm::smoothstep(0.55F, 0.62F, fractal_noise(9.0F * p, 3, seed));
  return glm::mix(color, glm::vec3(0.85F, 0.78F, 0.45F), spots);
}

}  // namespace

float value_noise(const glm::vec3& p, std::uint32_t seed) {
  const int x = floor_to_int(p.x), y = floor_to_int(p.y), z = floor_to_int(p.z);
  const glm::vec3 f = p - glm::vec3(x, y, z);
  const glm::vec3 s = f * f * (3.0F - 2.0F * f);
  const auto along_x = [&](int dy, int dz) {
    return glm::mix(lattice(x, y + dy, z + dz, seed), lattice(x + 1, y + dy, z + dz, seed), s.x);
  };
  return glm::mix(glm::mix(along_x(0, 0), along_x(1, 0), s.y),
                  glm::mix(along_x(0, 1), along_x(1, 1), s.y), s.z);
}

float fractal_noise(const glm::vec3& p, int octaves, std::uint32_t seed) {
  float sum = 0, weight = 0.5F, total = 0;
  glm::vec3 q = p;
  for (int i = 0; i < octaves; ++i) {
    sum += weight * value_noise(q, seed + static_cast<std::uint32_t>(i));
    total += weight;
    weight *= 0.5F;
    q *= 2.0F;
  }
  return sum / total;
}

glm::vec3 texture_color(Texture texture, const glm::vec3& color, const glm::vec3& p,
                        std::uint32_t seed) {
  switch (texture) {
    case Texture::kCheckerMarble:
      return checker_marble(color, p, seed);
    case Texture::kPlasterStripes:
      return plaster_stripes(color, p, seed);
    case Texture::kBands:
      return bands(color, p);
    case Texture::kSpeckles:
      return speckles(color, p, seed);
    case Texture::kPlain:
      break;
  }
  return color;
}

}  // namespace fluxgs::capture
