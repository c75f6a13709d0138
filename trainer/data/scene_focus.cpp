#include "trainer/data/scene_focus.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <glm/geometric.hpp>

namespace fluxgs {
namespace {

Eigen::Vector3d to_eigen(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

std::optional<glm::dvec3> nearest_point_to_rays(const std::vector<Ray>& rays) {
  if (rays.size() < 2) return std::nullopt;
  // Relative to the first origin: scenes may lie 1e5 units from the world's.
  const Eigen::Vector3d base = to_eigen(rays[0].origin);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Ray& ray : rays) {
    const Eigen::Vector3d d = to_eigen(ray.direction);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    normal += across;
    right += across * (to_eigen(ray.origin) - base);
  }
  // The smallest eigenvalue is the number of rays times the mean square sine of their angles.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal, Eigen::EigenvaluesOnly);
  constexpr double kMinSquareSine = 2e-5;
  if (!(eigen.eigenvalues()[0] > kMinSquareSine * static_cast<double>(rays.size())))
    return std::nullopt;
  const Eigen::Vector3d p = base + normal.ldlt().solve(right);
  return glm::dvec3(p[0], p[1], p[2]);
}

std::vector<Ray> view_rays(const std::vector<Camera>& cameras) {
  std::vector<Ray> rays;
  rays.reserve(cameras.size());
  for (const Camera& camera : cameras) rays.push_back({camera.center(), camera.forward()});
  return rays;
}

Ray pixel_ray(const Camera& camera, const glm::dvec2& pixel) {
  const glm::dvec3 in_camera((pixel.x - camera.cx) / camera.fx, (pixel.y - camera.cy) / camera.fy,
                             1.0);
  return {camera.center(), glm::normalize(glm::transpose(camera.rotation) * in_camera)};
}

bool in_frame(const Camera& camera, const glm::dvec3& point) {
  const glm::dvec3 at = camera.rotation * point + camera.translation;
  if (at.z <= 0) return false;
  const double x = camera.fx * at.x / at.z + camera.cx, y = camera.fy * at.y / at.z + camera.cy;
  return x >= 0 && y >= 0 && x < camera.width && y < camera.height;
}

double camera_spread(const std::vector<Camera>& cameras) {
  glm::dvec3 low = cameras.at(0).center(), high = low;
  for (const Camera& camera : cameras) {
    low = glm::min(low, camera.center());
    high = glm::max(high, camera.center());
  }
  return glm::distance(low, high);
}

std::vector<double> focus_distances(const std::vector<View>& views) {
  const std::vector<Camera> cameras = cameras_of(views);
  const std::vector<Ray> rays = view_rays(cameras);
  const auto focus = nearest_point_to_rays(rays);
  const double spread = camera_spread(cameras);

  std::vector<double> distances(rays.size(), 0.0);
  double sum = 0, count = 0;
  for (std::size_t i = 0; focus && i < rays.size(); ++i) {
    const double distance = glm::dot(*focus - rays[i].origin, rays[i].direction);
    if (!(distance > 0.05 * spread)) continue;
    distances[i] = distance;
    sum += distance;
    count += 1;
  }
  const double fallback = count > 0 ? sum / count : spread > 0 ? spread : 1.0;
  std::ranges::replace(distances, 0.0, fallback);
  return distances;
}

}  // namespace fluxgs
