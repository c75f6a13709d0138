#include "trainer/data/scale_check.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "fluxgs/render_options.h"
#include "trainer/core/median.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs {
namespace {

constexpr std::size_t kMaxCameras = 32, kMaxPoints = 1000;  // enough for a median
constexpr double kMaxBlur = 0.1;
constexpr double kMinNearPlanes = 5;

/// Median depth of some points, evenly spread, in front of a camera.
std::optional<double> depth_of_points(const Camera& camera, const std::vector<glm::vec3>& points) {
  std::vector<double> depths;
  const std::size_t stride = points.size() / kMaxPoints + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const double depth = glm::dot(glm::dvec3(points[i]) - camera.center(), camera.forward());
    if (depth > 0) depths.push_back(depth);
  }
  return median(std::move(depths));
}

/// Median depth of the point that views meet in. A panorama's lies among its cameras, behind many
/// of them.
std::optional<double> depth_of_focus(const std::vector<Camera>& cameras) {
  constexpr double kMinInFront = 0.75, kMinSpreads = 0.2;
  const std::vector<Ray> views = view_rays(cameras);
  const auto focus = nearest_point_to_rays(views);
  if (!focus) return std::nullopt;
  std::vector<double> depths;
  for (const Ray& view : views) {
    const double depth = glm::dot(*focus - view.origin, view.direction);
    if (depth > 0) depths.push_back(depth);
  }
  if (static_cast<double>(depths.size()) < kMinInFront * static_cast<double>(views.size()))
    return std::nullopt;
  const auto depth = median(std::move(depths));
  return depth > kMinSpreads * camera_spread(cameras) ? depth : std::nullopt;
}

/// Distance of cameras that look the same way, such as those of a flight over a map; 0 of
/// others, and of those in one place but for rounding.
double parallel_spread(const std::vector<Camera>& cameras) {
  if (nearest_point_to_rays(view_rays(cameras))) return 0;
  constexpr double kRounding = 1e-9;
  const double spread = camera_spread(cameras);
  return spread > kRounding * (1 + glm::length(cameras[0].center())) ? spread : 0.0;
}

/// Share of some points, evenly spread, that a camera sees.
double share_in_view(const Camera& camera, const std::vector<glm::vec3>& points) {
  const std::size_t stride = points.size() / kMaxPoints + 1;
  double seen = 0, all = 0;
  for (std::size_t i = 0; i < points.size(); i += stride, ++all)
    seen += in_frame(camera, points[i]);
  return seen / all;
}

/// True if most cameras look past the sparse points, which were found in their images.
bool looks_past_points(const Dataset& data) {
  constexpr std::size_t kFewest = 100;
  constexpr double kLeastShare = 0.003;
  if (data.points.size() < kFewest) return false;
  std::vector<double> shares;
  for (const Camera& camera : spread_cameras(cameras_of(data.train), kMaxCameras))
    shares.push_back(share_in_view(camera, data.points));
  return median(std::move(shares)).value() < kLeastShare;
}

/// Largest error of a position by rounding to 32 bits.
double rounding_at(double distance) { return std::ldexp(distance, -24); }

}  // namespace

std::optional<double> typical_depth(const Dataset& data) {
  const std::vector<Camera> cameras = spread_cameras(cameras_of(data.train), kMaxCameras);
  std::vector<double> depths;
  for (const Camera& camera : cameras)
    if (const auto depth = depth_of_points(camera, data.points)) depths.push_back(*depth);
  return depths.empty() ? depth_of_focus(cameras) : median(std::move(depths));
}

std::vector<std::string> scale_warnings(const Dataset& data) {
  std::vector<double> distances, focal_lengths;
  for (const View& view : data.train) {
    distances.push_back(glm::length(view.camera.center()));
    focal_lengths.push_back(view.camera.fx);
  }
  const double distance = median(std::move(distances)).value();
  const auto depth = typical_depth(data);
  const double size = depth ? *depth : parallel_spread(cameras_of(data.train));
  const double pixels = rounding_at(distance) / size * median(std::move(focal_lengths)).value();
  std::vector<std::string> lines;
  if (size > 0 && pixels > kMaxBlur)
    lines.push_back(fmt::format(
        "the cameras are {:.3g} units from the origin, where numbers of 32 bits are wrong by up to "
        "{:.2g} pixels of an image; move poses and points to the origin",
        distance, pixels));
  if (looks_past_points(data))
    lines.emplace_back(
        "most images show none of the sparse points; are the poses world to camera, as COLMAP has "
        "them, or camera to world with y up and z backward, as transforms.json has them?");
  const double near = RenderOptions().near_plane;
  if (depth && *depth < kMinNearPlanes * near)
    lines.push_back(fmt::format(
        "what the cameras see is {:.3g} units away, and nothing within {:g} is drawn; scale poses "
        "and points up",
        *depth, near));
  return lines;
}

}  // namespace fluxgs
