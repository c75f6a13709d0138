#include "tools/capture/scene.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace fluxgs::capture {
namespace {

constexpr float kHair = 1e-3F;

/// The distance to a sphere from outside; negative if it is missed.
float sphere_distance(const Sphere& sphere, const glm::vec3& origin, const glm::vec3& direction) {
  const glm::vec3 to_center = sphere.center - origin;
  const float along = glm::dot(to_center, direction);
  const glm::vec3 across = to_center - along * direction;
  const float half_chord2 = sphere.radius * sphere.radius - glm::dot(across, across);
  return half_chord2 < 0 ? -1.0F : along - std::sqrt(half_chord2);
}

void keep_nearest(std::optional<Hit>& best, float distance, const glm::vec3& position,
                  const glm::vec3& normal, const Material& material) {
  if (!best || distance < best->distance) best = Hit{distance, position, normal, &material};
}

void intersect_floor(const Scene& scene, const glm::vec3& origin, const glm::vec3& direction,
                     std::optional<Hit>& best) {
  if (!(direction.z < 0)) return;  // It has no underside.
  const float distance = -origin.z / direction.z;
  const glm::vec3 p = origin + distance * direction;
  const float radius2 = scene.floor_radius * scene.floor_radius;
  if (distance > kHair && p.x * p.x + p.y * p.y < radius2 && p.y < scene.wall_y)
    keep_nearest(best, distance, p, {0, 0, 1}, scene.floor);
}

void intersect_wall(const Scene& scene, const glm::vec3& origin, const glm::vec3& direction,
                    std::optional<Hit>& best) {
  if (!(direction.y > 0)) return;
  const float distance = (scene.wall_y - origin.y) / direction.y;
  const glm::vec3 p = origin + distance * direction;
  if (distance > kHair && std::abs(p.x) < scene.wall_half_width && p.z > 0 &&
      p.z < scene.wall_height)
    keep_nearest(best, distance, p, {0, -1, 0}, scene.wall);
}

}  // namespace

Scene make_scene(std::uint32_t seed) {
  using glm::vec3;
  Scene scene;
  scene.seed = seed;
  scene.floor = {Texture::kCheckerMarble, {0.78F, 0.75F, 0.69F}, 0.18F, false};
  scene.wall = {Texture::kPlasterStripes, {0.16F, 0.34F, 0.37F}, 0.8F, false};
  const Material chrome{Texture::kPlain, {0.93F, 0.94F, 0.96F}, 0.04F, true};
  const Material lacquer{Texture::kPlain, {0.62F, 0.025F, 0.02F}, 0.1F, false};
  const Material gold{Texture::kPlain, {1.0F, 0.70F, 0.27F}, 0.3F, true};
  const Material banded{Texture::kBands, {0.03F, 0.09F, 0.42F}, 0.12F, false};
  const Material jade{Texture::kSpeckles, {0.03F, 0.26F, 0.12F}, 0.16F, false};
  const Material pearl{Texture::kPlain, {0.80F, 0.74F, 0.70F}, 0.22F, false};
  scene.spheres = {
      {{-0.95F, 0.75F, 0.80F}, 0.80F, chrome},  {{0.85F, 0.45F, 0.60F}, 0.60F, lacquer},
      {{0.05F, -0.55F, 0.38F}, 0.38F, gold},    {{-1.05F, -0.75F, 0.32F}, 0.32F, banded},
      {{1.20F, -0.75F, 0.28F}, 0.28F, jade},    {{0.10F, 1.30F, 0.35F}, 0.35F, pearl},
      {{0.45F, -1.35F, 0.17F}, 0.17F, lacquer}, {{-0.42F, -1.30F, 0.14F}, 0.14F, chrome}};
  return scene;
}

std::optional<Hit> intersect(const Scene& scene, const glm::vec3& origin,
                             const glm::vec3& direction) {
  std::optional<Hit> best;
  for (const Sphere& sphere : scene.spheres) {
    const float distance = sphere_distance(sphere, origin, direction);
    if (distance < kHair) continue;
    const glm::vec3 p = origin + distance * direction;
    keep_nearest(best, distance, p, (p - sphere.center) / sphere.radius, sphere.material);
  }
  intersect_floor(scene, origin, direction, best);
  intersect_wall(scene, origin, direction, best);
  return best;
}

float light_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& to_light,
                       float tangent_of_radius) {
  float visible = 1;
  for (const Sphere& sphere : scene.spheres) {
    const glm::vec3 to_center = sphere.center - position;
    const float along = glm::dot(to_center, to_light);
    if (along <= 0) continue;
    const float gap = glm::length(to_center - along * to_light) - sphere.radius;
    const float penumbra = along * tangent_of_radius;
    visible *= glm::smoothstep(-penumbra, penumbra, gap);
  }
  return visible;
}

float sky_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& normal) {
  float visible = 1;
  for (const Sphere& sphere : scene.spheres) {
    const glm::vec3 to_center = sphere.center - position;
    const float distance2 = glm::dot(to_center, to_center);
    // A surface on the sphere itself has its centre behind it and is not darkened.
    const float cosine = glm::dot(normal, to_center) / std::sqrt(distance2);
    visible *= 1 - std::clamp(cosine * sphere.radius * sphere.radius / distance2, 0.0F, 1.0F);
  }
  const float from_wall = scene.wall_y - position.y, from_floor = position.z;
  const float corner = normal.z > 0.9F ? from_wall : normal.y < -0.9F ? from_floor : 10.0F;
  return visible * (1 - 0.45F * std::exp(-corner / 0.45F));
}

}  // namespace fluxgs::capture
