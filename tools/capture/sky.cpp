#include "tools/capture/sky.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "tools/capture/noise.h"

namespace fluxgs::capture {
namespace {

using glm::vec3;

/// 1 within a rectangle of directions around `center`, with a soft rim.
float softbox(const vec3& direction, const vec3& center, float half_width, float half_height) {
  const vec3 right = glm::normalize(glm::cross(center, vec3(0, 0, 1)));
  const vec3 up = glm::cross(right, center);
  const float along = glm::dot(direction, center);
  if (along <= 0) return 0;
  const float x = std::abs(glm::dot(direction, right)) / along;
  const float y = std::abs(glm::dot(direction, up)) / along;
  constexpr float kRim = 0.03F;
  return glm::smoothstep(half_width + kRim, half_width - kRim, x) *
         glm::smoothstep(half_height + kRim, half_height - kRim, y);
}

/// A window: a box with a cross of bars.
float window(const vec3& direction, const vec3& center) {
  const float pane = softbox(direction, center, 0.4F, 0.34F);
  const float bars =
      std::max(softbox(direction, center, 0.03F, 0.5F), softbox(direction, center, 0.5F, 0.03F));
  return pane * (1 - bars);
}

vec3 studio(const vec3& direction) {
  const vec3 zenith(0.16F, 0.24F, 0.40F), horizon(0.66F, 0.66F, 0.64F),
      ground(0.10F, 0.09F, 0.085F);
  const float z = direction.z;
  vec3 light = z > 0 ? glm::mix(horizon, zenith, std::sqrt(std::min(z, 1.0F)))
                     : glm::mix(horizon, ground, glm::smoothstep(0.0F, 0.35F, -z));
  static const vec3 kKey = glm::normalize(vec3(-0.9F, -0.75F, 0.8F));
  static const vec3 kFill = glm::normalize(vec3(1.0F, -0.35F, 0.55F));
  static const vec3 kWindow = glm::normalize(vec3(0.25F, -1.0F, 0.65F));
  light += vec3(3.2F, 3.0F, 2.7F) * softbox(direction, kKey, 0.26F, 0.36F);
  light += vec3(1.3F, 1.6F, 2.1F) * softbox(direction, kFill, 0.16F, 0.5F);
  light += vec3(1.9F, 2.0F, 2.1F) * window(direction, kWindow);
  return light;
}

/// A layer of clouds, thicker and greyer in the middle of each, that thins out into the haze.
vec3 clouds(const vec3& direction, std::uint32_t seed) {
  const vec3 zenith(0.10F, 0.24F, 0.62F), horizon(0.62F, 0.72F, 0.82F);
  const float z = std::max(direction.z, 0.0F);
  const vec3 blue = glm::mix(horizon, zenith, std::sqrt(z));
  const vec3 place(vec3(direction.x, direction.y, 0) / (z + 0.15F));
  const float thickness = fractal_noise(1.4F * place + vec3(0, 0, 0.5F), 6, seed);
  const vec3 cloud =
      glm::mix(vec3(1.5F), vec3(0.75F, 0.78F, 0.84F), glm::smoothstep(0.55F, 0.75F, thickness));
  const float cover = glm::smoothstep(0.47F, 0.58F, thickness) * glm::smoothstep(0.0F, 0.15F, z);
  return glm::mix(blue, cloud, cover);
}

}  // namespace

vec3 sky_light(Sky sky, const vec3& direction, std::uint32_t seed) {
  return sky == Sky::kStudio ? studio(direction) : clouds(direction, seed);
}

}  // namespace fluxgs::capture
