#include "trainer/data/random_points.h"

#include <algorithm>
#include <random>

#include "trainer/data/scene_focus.h"

namespace fluxgs {
namespace {

constexpr double kNear = 0.4, kFar = 2.0;  // times the focus distance

/// Uniform in [0, 1). The standard's distributions differ between libraries, its engines do not.
double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1.0p-53; }

int uniform_index(std::mt19937_64& engine, int count) {
  return std::min(static_cast<int>(uniform(engine) * count), count - 1);
}

}  // namespace

PointCloud random_points(const std::vector<Photo>& photos, std::size_t count, std::uint64_t seed) {
  const std::vector<double> distances = focus_distances(photos);
  std::mt19937_64 engine(seed);
  PointCloud cloud{.positions = {}, .colors = {}, .source = "random"};
  for (std::size_t i = 0; i < count; ++i) {
    const auto view =
        static_cast<std::size_t>(uniform_index(engine, static_cast<int>(photos.size())));
    const Photo& photo = photos[view];
    const int x = uniform_index(engine, photo.rgb.width);
    const int y = uniform_index(engine, photo.rgb.height);
    const double depth = distances[view] * (kNear + (kFar - kNear) * uniform(engine));
    const Ray ray = pixel_ray(photo.camera, {x + 0.5, y + 0.5});
    const double along = depth / glm::dot(ray.direction, photo.camera.forward());
    const std::uint8_t* rgb = photo.rgb.at(x, y);
    cloud.positions.emplace_back(ray.origin + along * ray.direction);
    cloud.colors.push_back(glm::vec3(rgb[0], rgb[1], rgb[2]) / 255.0F);
  }
  return cloud;
}

}  // namespace fluxgs
