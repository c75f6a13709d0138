#include "tools/capture/shading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace fluxgs::capture {
namespace {

using glm::vec3;

struct Lamp {
  vec3 direction;  ///< towards it
  vec3 light;      ///< linear RGB, as irradiance over π
  float tangent_of_radius;
};

const std::array<Lamp, 3>& lamps() {
  static const std::array<Lamp, 3> kLamps{{
      {glm::normalize(vec3(-0.55F, -0.65F, 0.95F)), {1.75F, 1.58F, 1.32F}, 0.09F},
      {glm::normalize(vec3(0.95F, -0.55F, 0.75F)), {0.42F, 0.50F, 0.66F}, 0.16F},
      {glm::normalize(vec3(0.15F, -0.9F, 0.35F)), {0.22F, 0.19F, 0.17F}, 0.12F},
  }};
  return kLamps;
}

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

/// GGX highlight times cosine, for reflectance f0 at normal incidence (Walter et al. 2007;
/// Schlick's Fresnel; the height-correlated visibility in Hammon's approximation).
vec3 highlight(const vec3& normal, const vec3& view, const vec3& light, float roughness,
               const vec3& f0) {
  const float nl = glm::dot(normal, light), nv = std::max(glm::dot(normal, view), 1e-3F);
  if (nl <= 0) return vec3(0);
  const vec3 half = glm::normalize(view + light);
  const float nh = std::max(glm::dot(normal, half), 0.0F);
  const float a = std::max(roughness * roughness, 0.004F), a2 = a * a;
  const float d = nh * nh * (a2 - 1) + 1;
  const float distribution = a2 / (std::numbers::pi_v<float> * d * d);
  const float visibility = 0.5F / glm::mix(2 * nl * nv, nl + nv, a);
  const vec3 fresnel =
      f0 + (vec3(1) - f0) * std::pow(1 - std::max(glm::dot(view, half), 0.0F), 5.0F);
  return fresnel * (distribution * visibility * nl);
}

/// Share of light that a surface mirrors at this angle; rough ones less (after Karis 2013).
vec3 mirror_part(const vec3& f0, float roughness, float nv) {
  const vec3 grazing = glm::max(vec3(1 - roughness), f0);
  return f0 + (grazing - f0) * std::pow(1 - nv, 5.0F);
}

/// The diffuse light of the environment on a surface that faces `normal`.
vec3 ambient(const vec3& normal) {
  return glm::mix(vec3(0.12F, 0.11F, 0.10F), vec3(0.32F, 0.36F, 0.42F), 0.5F + 0.5F * normal.z);
}

vec3 mirrored(const Scene& scene, const Hit& hit, const vec3& direction, int bounces) {
  const vec3 reflected = glm::reflect(direction, hit.normal);
  constexpr float kSharp = 0.25F;
  if (hit.material->roughness < kSharp && bounces > 0)
    return radiance(scene, hit.position, reflected, bounces - 1);
  // Too rough for a mirror image: the sky around the reflected direction, and the floor below it.
  return ambient(reflected);
}

}  // namespace

vec3 environment(const vec3& direction) {
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

vec3 radiance(const Scene& scene, const vec3& origin, const vec3& direction, int bounces) {
  const auto hit = intersect(scene, origin, direction);
  if (!hit) return environment(direction);
  const Material& material = *hit->material;
  const vec3 color = texture_color(material.texture, material.color, hit->position, scene.seed);
  const vec3 f0 = material.metal ? color : vec3(0.045F);
  const vec3 view = -direction;

  const float open = sky_visibility(scene, hit->position, hit->normal);
  const vec3 mirror =
      mirror_part(f0, material.roughness, std::clamp(glm::dot(hit->normal, view), 0.0F, 1.0F));
  vec3 light = material.metal ? vec3(0) : color * ambient(hit->normal) * open;
  if (std::max({mirror.x, mirror.y, mirror.z}) > 0.01F)
    light += mirror * mirrored(scene, *hit, direction, bounces);
  for (const Lamp& lamp : lamps()) {
    const float cosine = glm::dot(hit->normal, lamp.direction);
    if (cosine <= 0) continue;
    const float visible =
        light_visibility(scene, hit->position, lamp.direction, lamp.tangent_of_radius);
    if (visible <= 0) continue;
    if (!material.metal) light += color * lamp.light * (cosine * visible);
    light += highlight(hit->normal, view, lamp.direction, material.roughness, f0) * lamp.light *
             (visible * std::numbers::pi_v<float>);
  }
  return light;
}

vec3 tone_map(const vec3& light) {
  // The rational fit of a film's response by Narkowicz (2015).
  constexpr float kExposure = 0.62F;
  const vec3 l = light * kExposure;
  return glm::clamp(l * (2.51F * l + 0.03F) / (l * (2.43F * l + 0.59F) + 0.14F), 0.0F, 1.0F);
}

float srgb_encode(float linear) {
  return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
}

}  // namespace fluxgs::capture
