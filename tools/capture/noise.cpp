#include "tools/capture/noise.h"

#include <initializer_list>

#include <glm/common.hpp>

namespace fluxgs::capture {

int floor_to_int(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

// A multiply–xorshift hash.
float grid_noise(int x, int y, int z, std::uint32_t seed) {
  std::uint32_t h = seed;
  for (const int c : {x, y, z}) {
    h = (h ^ static_cast<std::uint32_t>(c)) * 0x9e3779b1U;
    h ^= h >> 15;
  }
  h *= 0x85ebca77U;
  return static_cast<float>((h ^ h >> 13) >> 8) * 0x1p-24F;
}

float value_noise(const glm::vec3& p, std::uint32_t seed) {
  const int x = floor_to_int(p.x), y = floor_to_int(p.y), z = floor_to_int(p.z);
  const glm::vec3 f = p - glm::vec3(x, y, z);
  const glm::vec3 s = f * f * (3.0F - 2.0F * f);
  const auto along_x = [&](int dy, int dz) {
    return glm::mix(grid_noise(x, y + dy, z + dz, seed), grid_noise(x + 1, y + dy, z + dz, seed),
                    s.x);
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

float detail_noise(const glm::vec3& p, int octaves, float gain, float footprint,
                   std::uint32_t seed) {
  float sum = 0, weight = 1, total = 0, frequency = 1;
  for (int i = 0; i < octaves; ++i) {
    const float shown = 1 - glm::smoothstep(0.5F, 1.5F, footprint * frequency);
    if (shown > 0)
      sum += weight * shown *
             (value_noise(frequency * p, seed + static_cast<std::uint32_t>(i)) - 0.5F);
    total += weight;
    weight *= gain;
    frequency *= 2;
  }
  return 0.5F + sum / total;
}

}  // namespace fluxgs::capture
