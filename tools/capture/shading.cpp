#include "tools/capture/shading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace fluxgs::capture {
namespace {

using glm::vec3;

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

/// The diffuse light from all around on a surface that faces `normal`.
vec3 ambient(const Scene& scene, const vec3& normal) {
  return glm::mix(scene.light_below, scene.light_above, 0.5F + 0.5F * normal.z);
}

/// The texture as a camera shows it that has a pixel every 0.0025 rad, as 400 across 60° are.
vec3 surface_color(const Scene& scene, const Hit& hit, float cosine) {
  constexpr float kPixelAngle = 0.0025F;
  const Material& material = *hit.material;
  // A pixel's place on the surface is longer than wide; its area counts.
  const float footprint = hit.distance * kPixelAngle / std::sqrt(std::max(cosine, 0.02F));
  return texture_color(material.texture, material.color, hit.position / material.size,
                       footprint / material.size, scene.seed);
}

vec3 mirrored(const Scene& scene, const Hit& hit, const vec3& direction, int bounces) {
  const vec3 reflected = glm::reflect(direction, hit.normal);
  constexpr float kSharp = 0.25F;
  if (hit.material->roughness < kSharp && bounces > 0)
    return radiance(scene, hit.position, reflected, bounces - 1);
  // Too rough for a mirror image: the sky around the reflected direction, and the floor below it.
  return ambient(scene, reflected);
}

vec3 through_haze(const Scene& scene, const vec3& light, float distance) {
  const vec3 haze(0.62F, 0.72F, 0.82F);
  return glm::mix(haze, light, std::exp(-scene.haze * distance));
}

}  // namespace

vec3 radiance(const Scene& scene, const vec3& origin, const vec3& direction, int bounces) {
  const auto hit = intersect(scene, origin, direction);
  if (!hit) return sky_light(scene.sky, direction, scene.seed);
  const Material& material = *hit->material;
  const vec3 view = -direction;
  const float facing = std::clamp(glm::dot(hit->normal, view), 0.0F, 1.0F);
  const vec3 color = surface_color(scene, *hit, facing);
  const vec3 f0 = material.metal ? color : vec3(0.045F);

  const float open = sky_visibility(scene, hit->position, hit->normal);
  const vec3 mirror = mirror_part(f0, material.roughness, facing);
  vec3 light = material.metal ? vec3(0) : color * ambient(scene, hit->normal) * open;
  if (std::max({mirror.x, mirror.y, mirror.z}) > 0.01F)
    light += mirror * mirrored(scene, *hit, direction, bounces);
  for (const Lamp& lamp : scene.lamps) {
    const float cosine = glm::dot(hit->normal, lamp.direction);
    if (cosine <= 0) continue;
    const float visible =
        light_visibility(scene, hit->position, lamp.direction, lamp.tangent_of_radius);
    if (visible <= 0) continue;
    if (!material.metal) light += color * lamp.light * (cosine * visible);
    light += highlight(hit->normal, view, lamp.direction, material.roughness, f0) * lamp.light *
             (visible * std::numbers::pi_v<float>);
  }
  return through_haze(scene, light, hit->distance);
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
