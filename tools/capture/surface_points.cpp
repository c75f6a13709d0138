#include "tools/capture/surface_points.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "tools/capture/shading.h"
#include "trainer/core/random.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs::capture {
namespace {

constexpr int kNoBounces = 0;  // a point's colour needs no reflections

glm::vec3 random_ray(const Camera& camera, Random& random) {
  const double x = uniform(random) * camera.width, y = uniform(random) * camera.height;
  return glm::normalize(pixel_ray(camera, {x, y}).direction);
}

void append(std::string& bytes, const Hit& hit, const glm::vec3& color) {
  const float position[] = {hit.position.x, hit.position.y, hit.position.z};
  char point[sizeof position + 3];
  std::memcpy(point, position, sizeof position);  // little-endian, as all that we run on
  for (int c = 0; c < 3; ++c)
    point[sizeof position + static_cast<std::size_t>(c)] =
        static_cast<char>(std::lround(255 * srgb_encode(color[c])));
  bytes.append(point, sizeof point);
}

}  // namespace

std::string surface_points_ply(const Scene& scene, const std::vector<Camera>& cameras, int count,
                               std::uint64_t seed) {
  constexpr int kTries = 50;  // for each point
  Random random(seed);
  std::string points;
  int found = 0;
  for (std::int64_t tries = std::int64_t{kTries} * count; found < count && tries > 0; --tries) {
    const auto at = static_cast<std::size_t>(uniform(random) * static_cast<double>(cameras.size()));
    const Camera& camera = cameras[std::min(at, cameras.size() - 1)];
    const glm::vec3 origin(camera.center()), direction = random_ray(camera, random);
    const auto hit = intersect(scene, origin, direction);
    if (!hit) continue;
    append(points, *hit, tone_map(radiance(scene, origin, direction, kNoBounces)));
    ++found;
  }
  return fmt::format(
             "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
             "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
             "property uchar blue\nend_header\n",
             found) +
         points;
}

}  // namespace fluxgs::capture
