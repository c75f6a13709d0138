// Small scenes, cameras and comparisons for the renderer's tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <string>

#include "fluxgs/camera.h"
#include "fluxgs/image.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "fluxgs/splat_cloud.h"
#include "support/sanitized.h"
#include "tools/reference/reference_renderer.h"

namespace fluxgs::test {

struct SimpleSplat {
  glm::vec3 position{0, 0, 0};
  glm::vec3 scale{0.1F, 0.1F, 0.1F};  ///< deviations, scene units
  glm::quat rotation{1, 0, 0, 0};
  float opacity = 0.8F;
  glm::vec3 color{1, 0, 0};
};

/// Appends a splat to a cloud of any degree; coefficients beyond the constant one are 0.
inline void add(SplatCloud& cloud, const SimpleSplat& splat) {
  cloud.positions.push_back(splat.position);
  cloud.log_scales.push_back(glm::log(splat.scale));
  cloud.rotations.push_back(splat.rotation);
  cloud.opacity_logits.push_back(std::log(splat.opacity / (1 - splat.opacity)));
  cloud.sh_dc.push_back((splat.color - 0.5F) / static_cast<float>(math::kSh0));
  cloud.sh_rest.resize(cloud.size() * static_cast<std::size_t>(sh_rest_count(cloud.sh_degree)));
}

/// `count` splats of every shape in a ball of radius 1 around `centre`, with random SH coefficients
/// and quaternions of any length.
inline SplatCloud random_cloud(std::size_t count, int sh_degree, std::uint32_t seed,
                               const glm::vec3& centre = {0, 0, 0}) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  const auto vector = [&] { return glm::vec3(normal(random), normal(random), normal(random)); };
  SplatCloud cloud;
  cloud.sh_degree = sh_degree;
  cloud.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions[i] = centre + glm::normalize(vector()) * std::cbrt(uniform(random));
    cloud.log_scales[i] = -4.5F + 0.8F * vector();
    cloud.rotations[i] = {normal(random), normal(random), normal(random), normal(random)};
    cloud.opacity_logits[i] = 2.0F * normal(random);
    cloud.sh_dc[i] = vector();
  }
  for (glm::vec3& c : cloud.sh_rest) c = 0.2F * vector();
  return cloud;
}

/// random_cloud() of degree 3 in which splats do without the bands above degrees 3, 0, 2, 1, 3, …
inline SplatCloud mixed_cloud(std::size_t count, std::uint32_t seed) {
  constexpr int kDegrees[] = {3, 0, 2, 1};
  SplatCloud cloud = random_cloud(count, 3, seed);
  const auto rest = static_cast<std::ptrdiff_t>(sh_rest_count(3));
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = cloud.sh_rest.begin() + rest * static_cast<std::ptrdiff_t>(i);
    std::fill(first + sh_rest_count(kDegrees[i % 4]), first + rest, glm::vec3(0));
  }
  return cloud;
}

/// At (0, 0, −distance), looking along +z with a vertical field of view of about 53°.
inline Camera front_camera(int width, int height, double distance) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = height;
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  camera.translation = {0, 0, distance};
  return camera;
}

/// Step `i` of `n` of an orbit around `centre` (y is down), looking slightly from above.
inline Camera orbit_camera(int width, int height, const glm::dvec3& centre, double distance, int i,
                           int n) {
  const double angle = 2 * std::numbers::pi * i / n;
  const glm::dvec3 outward = glm::normalize(glm::dvec3(std::sin(angle), -0.3, -std::cos(angle)));
  const glm::dvec3 forward = -outward;
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), forward));
  const glm::dvec3 down = glm::cross(forward, right);
  Camera camera = front_camera(width, height, distance);
  camera.rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.translation = -(camera.rotation * (centre + outward * distance));
  return camera;
}

/// The difference between an image and the reference.
struct Difference {
  double psnr = 0;      ///< dB, over RGB, for a signal of 1
  double greatest = 0;  ///< over RGB and 1 − A against transmittance
};

/// `image` is RGBA. With `clamp` the reference is limited to 0…1 first, as 8-bit targets are.
inline Difference compare(const Image<float>& image, const ReferenceImage& reference, bool clamp) {
  double sum = 0, greatest = 0;
  const std::size_t pixels = reference.transmittance.pixels.size();
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      double wanted = reference.color.pixels[3 * i + c];
      if (clamp) wanted = std::clamp(wanted, 0.0, 1.0);
      const double error = static_cast<double>(image.pixels[4 * i + c]) - wanted;
      sum += error * error;
      greatest = std::max(greatest, std::abs(error));
    }
    const double alpha = static_cast<double>(image.pixels[4 * i + 3]);
    greatest = std::max(greatest, std::abs(1 - alpha - reference.transmittance.pixels[i]));
  }
  return {-10 * std::log10(sum / static_cast<double>(3 * pixels)), greatest};
}

/// The plush dog of $FLUXGS_DATA; an empty cloud where the variable or the file is missing.
inline SplatCloud plush_dog() {
  const char* folder = std::getenv("FLUXGS_DATA");
  if (!folder) return {};
  const auto path = std::filesystem::path(folder) / "splats/plush-dog/point_cloud_29999_clean.ply";
  const auto bytes = read_file(path);
  if (!bytes) return {};
  auto scene = read_ply(*bytes, path.string());
  return scene ? std::move(scene->cloud) : SplatCloud{};
}

/// The mean position and a distance from which the whole of the plush dog is seen.
inline glm::dvec3 mean_position(const SplatCloud& cloud) {
  glm::dvec3 sum(0.0);
  for (const glm::vec3& p : cloud.positions) sum += glm::dvec3(p);
  return sum / static_cast<double>(std::max<std::size_t>(cloud.size(), 1));
}

/// Writes RGB to $FLUXGS_TEST_IMAGES/NAME.ppm, for people to look at; does nothing where that is
/// not set.
inline void keep_image(const std::string& name, const Image<float>& image) {
  const char* folder = std::getenv("FLUXGS_TEST_IMAGES");
  if (!folder) return;
  std::ofstream file(std::filesystem::path(folder) / (name + ".ppm"), std::ios::binary);
  file << "P6\n" << image.width << ' ' << image.height << "\n255\n";
  for (std::size_t i = 0; i < image.pixels.size(); i += static_cast<std::size_t>(image.channels))
    for (std::size_t c = 0; c < 3; ++c)
      file.put(static_cast<char>(std::lround(std::clamp(image.pixels[i + c], 0.0F, 1.0F) * 255)));
}

}  // namespace fluxgs::test
