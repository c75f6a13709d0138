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

void intersect_floor(const Floor& floor, const glm::vec3& origin, const glm::vec3& direction,
                     std::optional<Hit>& best) {
  if (!(direction.z < 0)) return;  // It has no underside.
  const float distance = -origin.z / direction.z;
  const glm::vec3 p = origin + distance * direction;
  if (distance > kHair && p.x * p.x + p.y * p.y < floor.radius * floor.radius && p.y < floor.end_y)
    keep_nearest(best, distance, p, {0, 0, 1}, floor.material);
}

bool between(float low, float x, float high) { return low < x && x < high; }

/// A ray can only enter through the nearer one of the two faces across each axis.
void intersect_box(const Box& box, const glm::vec3& origin, const glm::vec3& direction,
                   std::optional<Hit>& best) {
  for (int axis = 0; axis < 3; ++axis) {
    const float face = direction[axis] > 0 ? box.low[axis] : box.high[axis];
    // Infinite or not a number along the face: then no comparison below is true.
    const float distance = (face - origin[axis]) / direction[axis];
    if (!(distance > kHair)) continue;
    const glm::vec3 p = origin + distance * direction;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (!between(box.low[u], p[u], box.high[u]) || !between(box.low[v], p[v], box.high[v]))
      continue;
    glm::vec3 normal(0);
    normal[axis] = direction[axis] > 0 ? -1.0F : 1.0F;
    keep_nearest(best, distance, p, normal, box.material);
  }
}

float sphere_light(const Sphere& sphere, const glm::vec3& position, const glm::vec3& to_light,
                   float tangent_of_radius) {
  const glm::vec3 to_center = sphere.center - position;
  const float along = glm::dot(to_center, to_light);
  if (along <= 0) return 1;
  const float gap = glm::length(to_center - along * to_light) - sphere.radius;
  const float penumbra = along * tangent_of_radius;
  return glm::smoothstep(-penumbra, penumbra, gap);
}

/// From the length of the ray's way through the box; for a ray that misses it, from what is missing
/// to one.
float box_light(const Box& box, const glm::vec3& position, const glm::vec3& to_light,
                float tangent_of_radius) {
  const glm::vec3 a = (box.low - position) / to_light, b = (box.high - position) / to_light;
  const glm::vec3 near = glm::min(a, b), far = glm::max(a, b);
  const float enter = std::max({near.x, near.y, near.z, 0.0F});
  const float leave = std::min({far.x, far.y, far.z});
  if (leave <= kHair) return 1;
  const float penumbra = std::max(enter * tangent_of_radius, kHair);
  return glm::smoothstep(-penumbra, penumbra, enter - leave);
}

float sphere_sky(const Sphere& sphere, const glm::vec3& position, const glm::vec3& normal) {
  const glm::vec3 to_center = sphere.center - position;
  // A surface on the sphere itself has its centre behind it and is not darkened.
  const float facing = glm::dot(normal, to_center);
  if (facing <= 0) return 1;
  const float distance2 = glm::dot(to_center, to_center);
  const float cosine = facing / std::sqrt(distance2);
  return 1 - std::clamp(cosine * sphere.radius * sphere.radius / distance2, 0.0F, 1.0F);
}

float box_sky(const Box& box, const glm::vec3& position, const glm::vec3& normal) {
  const glm::vec3 to_box = glm::clamp(position, box.low, box.high) - position;
  const float distance = glm::length(to_box);
  const bool own = distance < kHair, behind = glm::dot(to_box, normal) < -kHair;
  return own || behind ? 1 : 1 - 0.5F * std::exp(-distance / 0.15F);
}

/// The distance from a point of one plane to the next other one; far if it is on none.
float corner_distance(const Scene& scene, const glm::vec3& position, const glm::vec3& normal) {
  float nearest = 10;
  for (const Plane& own : scene.planes) {
    if (glm::dot(normal, own.normal) <= 0.9F) continue;
    for (const Plane& other : scene.planes)
      if (std::abs(glm::dot(own.normal, other.normal)) < 0.5F)
        nearest = std::min(nearest, glm::dot(position, other.normal) - other.offset);
  }
  return nearest;
}

}  // namespace

std::optional<Hit> intersect(const Scene& scene, const glm::vec3& origin,
                             const glm::vec3& direction) {
  std::optional<Hit> best;
  for (const Sphere& sphere : scene.spheres) {
    const float distance = sphere_distance(sphere, origin, direction);
    if (distance < kHair) continue;
    const glm::vec3 p = origin + distance * direction;
    keep_nearest(best, distance, p, (p - sphere.center) / sphere.radius, sphere.material);
  }
  intersect_floor(scene.floor, origin, direction, best);
  for (const Box& box : scene.boxes) intersect_box(box, origin, direction, best);
  return best;
}

float light_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& to_light,
                       float tangent_of_radius) {
  float visible = 1;
  for (const Sphere& sphere : scene.spheres)
    visible *= sphere_light(sphere, position, to_light, tangent_of_radius);
  for (const Box& box : scene.boxes)
    if (box.shades) visible *= box_light(box, position, to_light, tangent_of_radius);
  return visible;
}

float sky_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& normal) {
  float visible = 1;
  for (const Sphere& sphere : scene.spheres) visible *= sphere_sky(sphere, position, normal);
  for (const Box& box : scene.boxes)
    if (box.shades) visible *= box_sky(box, position, normal);
  return visible * (1 - 0.45F * std::exp(-corner_distance(scene, position, normal) / 0.45F));
}

}  // namespace fluxgs::capture
