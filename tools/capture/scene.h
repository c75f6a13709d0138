// The scene: glossy spheres on a round floor before a wall. The world has z up.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "tools/capture/texture.h"

namespace fluxgs::capture {

struct Material {
  Texture texture = Texture::kPlain;
  glm::vec3 color{0.5F};   ///< linear RGB
  float roughness = 0.5F;  ///< GGX α is its square
  bool metal = false;      ///< reflects in its own colour and has no diffuse part
};

struct Sphere {
  glm::vec3 center{0};
  float radius = 1;
  Material material;
};

struct Scene {
  std::vector<Sphere> spheres;
  float floor_radius = 3.4F;  ///< a disc at z = 0
  Material floor;
  float wall_y = 2.1F, wall_half_width = 2.7F, wall_height = 2.5F;  ///< at y = wall_y, facing −y
  Material wall;
  std::uint32_t seed = 0;
};

Scene make_scene(std::uint32_t seed);

struct Hit {
  float distance = 0;
  glm::vec3 position{0}, normal{0};  ///< the normal is on the ray's side and of unit length
  const Material* material = nullptr;
};

/// The first surface along a ray with a unit direction, farther than a hair's breadth.
std::optional<Hit> intersect(const Scene& scene, const glm::vec3& origin,
                             const glm::vec3& direction);

/// The part (0…1) of a round light that spheres leave visible from a point: each covers it smoothly
/// over the width of its penumbra. No sampling, so shadows are soft without noise.
float light_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& to_light,
                       float tangent_of_radius);

/// The part (0…1) of the sky that neighbours leave visible: spheres by their form factor, the other
/// of floor and wall by an exponential towards the corner.
float sky_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& normal);

}  // namespace fluxgs::capture
