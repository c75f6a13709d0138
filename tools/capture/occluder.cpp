#include "tools/capture/occluder.h"

#include <cmath>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "trainer/core/random.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs::capture {
namespace {

/// The direction of a place of the image, in pixels.
glm::vec3 direction_of(const Camera& camera, double x, double y) {
  const Ray ray = pixel_ray(camera, {x, y});
  return glm::vec3(glm::normalize(ray.direction));
}

/// True if the ray of a place of the image meets the scene's last sphere first.
bool shows_last(const Scene& scene, const Camera& camera, double x, double y) {
  const auto hit = intersect(scene, glm::vec3(camera.center()), direction_of(camera, x, y));
  return hit && hit->material == &scene.spheres.back().material;
}

}  // namespace

Scene with_occluder(Scene scene, const Camera& camera, std::uint64_t seed) {
  constexpr double kDistance = 1.6;  // scene units from the camera; the scene is 5 away
  constexpr double kRadius = 0.3;
  Random random(seed);
  const double x = (0.15 + 0.7 * uniform(random)) * camera.width;
  const double y = (0.15 + 0.7 * uniform(random)) * camera.height;
  const glm::vec3 colors[] = {{0.9F, 0.02F, 0.5F}, {0.95F, 0.5F, 0.0F}, {0.05F, 0.7F, 0.9F}};
  const auto which = static_cast<std::size_t>(3 * uniform(random));
  Sphere ball;
  ball.center =
      glm::vec3(camera.center()) + static_cast<float>(kDistance) * direction_of(camera, x, y);
  ball.radius = static_cast<float>(kRadius);
  ball.material = {Texture::kBands, colors[which % 3], 0.6F, false};
  scene.spheres.push_back(ball);
  return scene;
}

Image<std::uint8_t> occluder_mask(const Scene& scene, const Camera& camera) {
  constexpr int kMargin = 1;  // pixels
  Image<std::uint8_t> mask(camera.width, camera.height, 3);
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      bool shown = false;
      for (int v = -kMargin; v <= kMargin + 1 && !shown; ++v)
        for (int u = -kMargin; u <= kMargin + 1 && !shown; ++u)
          shown = shows_last(scene, camera, x + u, y + v);
      for (int c = 0; c < 3; ++c) mask.at(x, y)[c] = shown ? 0 : 255;
    }
  });
  return mask;
}

}  // namespace fluxgs::capture
