// A scene: shapes, materials and lights. The world has z up.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "tools/capture/sky.h"
#include "tools/capture/texture.h"

namespace fluxgs::capture {

struct Material {
  Texture texture = Texture::kPlain;
  glm::vec3 color{0.5F};   ///< linear RGB
  float roughness = 0.5F;  ///< GGX α is its square
  bool metal = false;      ///< reflects in its own colour and has no diffuse part
  float size = 1;          ///< of the texture; 1: as of things that one can lift
};

struct Sphere {
  glm::vec3 center{0};
  float radius = 1;
  Material material;
};

/// Its edges are along the axes. A rectangle is a box of no thickness.
struct Box {
  glm::vec3 low{0}, high{0};
  Material material;
  bool shades = true;  ///< keeps light from others; not so the walls around a scene
};

/// A disc at z = 0 around the origin, seen from above.
struct Floor {
  float radius = 0;
  float end_y = std::numeric_limits<float>::infinity();  ///< there is none beyond this y
  Material material;
};

/// A large surface that faces `normal`, where dot(normal, p) = offset. Where two of them meet, both
/// are darker.
struct Plane {
  glm::vec3 normal{0};
  float offset = 0;
};

/// A round light, far away.
struct Lamp {
  glm::vec3 direction{0};  ///< towards it
  glm::vec3 light{0};      ///< linear RGB, as irradiance over π
  float tangent_of_radius = 0;
};

struct Scene {
  std::vector<Sphere> spheres;
  std::vector<Box> boxes;
  Floor floor;
  std::vector<Plane> planes;
  std::vector<Lamp> lamps;
  Sky sky = Sky::kStudio;
  glm::vec3 light_below{0}, light_above{0};  ///< the diffuse light from all around, linear RGB
  float haze = 0;                            ///< 1 / the distance at which it hides all but 1/e
  std::uint32_t seed = 0;                    ///< of the textures' noise
};

struct Hit {
  float distance = 0;
  glm::vec3 position{0}, normal{0};  ///< the normal is on the ray's side and of unit length
  const Material* material = nullptr;
};

/// The first surface along a ray with a unit direction, farther than a hair's breadth. Spheres and
/// boxes have no inside: a ray that starts there leaves them unseen.
std::optional<Hit> intersect(const Scene& scene, const glm::vec3& origin,
                             const glm::vec3& direction);

/// The part (0…1) of a round light that spheres and boxes leave visible from a point: each covers
/// it smoothly over the width of its penumbra. No sampling, so shadows are soft without noise.
float light_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& to_light,
                       float tangent_of_radius);

/// The part (0…1) of the sky that neighbours leave visible: spheres by their form factor, boxes by
/// an exponential of the distance, the other of two planes by one towards the corner.
float sky_visibility(const Scene& scene, const glm::vec3& position, const glm::vec3& normal);

}  // namespace fluxgs::capture
