// Small scenes and cameras that tests share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "fluxgs/camera.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::test {

/// A camera at (0, 0, −distance) that looks along +z at the origin.
inline Camera camera_in_front(int width, int height, double distance = 4.0, double focal = 0) {
  Camera c;
  c.name = "front";
  c.width = width;
  c.height = height;
  c.fx = c.fy = focal > 0 ? focal : 1.1 * std::max(width, height);
  c.cx = width * 0.5;
  c.cy = height * 0.5;
  c.translation = {0, 0, distance};
  return c;
}

/// A camera at `eye` that looks at `target`, y down.
inline Camera camera_at(const glm::dvec3& eye, const glm::dvec3& target, int width, int height) {
  Camera c = camera_in_front(width, height);
  const glm::dvec3 z = glm::normalize(target - eye);
  const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(0, 1, 0.01), z));
  const glm::dvec3 y = glm::cross(z, x);
  c.rotation = glm::transpose(glm::dmat3(x, y, z));
  c.translation = -(c.rotation * eye);
  return c;
}

/// One splat of the given standard deviation at `position`: grey 0.5 + 0.282·dc.
inline SplatCloud one_splat(const glm::vec3& position, float deviation, float opacity_logit,
                            const glm::vec3& dc = glm::vec3(1, 0, -1)) {
  SplatCloud cloud;
  cloud.resize(1);
  cloud.positions[0] = position;
  cloud.log_scales[0] = glm::vec3(std::log(deviation));
  cloud.opacity_logits[0] = opacity_logit;
  cloud.sh_dc[0] = dc;
  return cloud;
}

/// `count` splats in a box of half-size `spread` around the origin, with random shapes, colours
/// and view dependence.
inline SplatCloud random_cloud(std::size_t count, int sh_degree, std::uint32_t seed = 1,
                               float spread = 1.0f, float deviation = 0.05f) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> box(-spread, spread);
  std::normal_distribution<float> normal;
  const auto vec = [&](float s) {
    return glm::vec3(normal(random), normal(random), normal(random)) * s;
  };
  SplatCloud cloud;
  cloud.sh_degree = sh_degree;
  cloud.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions[i] = {box(random), box(random), box(random)};
    cloud.log_scales[i] = glm::vec3(std::log(deviation)) + vec(0.7f);
    cloud.rotations[i] = glm::quat(normal(random), normal(random), normal(random), normal(random));
    cloud.opacity_logits[i] = 1.5f * normal(random);
    cloud.sh_dc[i] = vec(1.0f);
  }
  for (glm::vec3& c : cloud.sh_rest) c = vec(0.15f);
  return cloud;
}

}  // namespace fluxgs::test
