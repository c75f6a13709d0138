#include "trainer/data/scale_check.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "fluxgs/render_options.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs {
namespace {

constexpr std::size_t kMostCameras = 32, kMostPoints = 1000;  // enough for a median
constexpr double kMostPixels = 0.1;
constexpr double kLeastNearPlanes = 5;

/// Of a list that is not empty.
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::optional<double> median_or_none(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  return median(std::move(values));
}

/// Of some points, evenly spread, in front of a camera.
std::optional<double> depth_of_points(const Camera& camera, const std::vector<glm::vec3>& points) {
  std::vector<double> depths;
  const std::size_t stride = points.size() / kMostPoints + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const double depth = glm::dot(glm::dvec3(points[i]) - camera.center(), camera.forward());
    if (depth > 0) depths.push_back(depth);
  }
  return median_or_none(std::move(depths));
}

/// Where views meet; behind a camera counts as nowhere.
std::vector<double> depths_of_focus(const std::vector<Camera>& cameras) {
  std::vector<Ray> views;
  for (const Camera& camera : cameras) views.push_back({camera.center(), camera.forward()});
  const auto focus = nearest_point_to_rays(views);
  std::vector<double> depths;
  for (const Ray& view : views) {
    const double depth = focus ? glm::dot(*focus - view.origin, view.direction) : 0.0;
    if (depth > 0) depths.push_back(depth);
  }
  return depths;
}

/// What rounding to 32 bits moves a position by, at most.
double rounding_at(double distance) { return std::ldexp(distance, -24); }

}  // namespace

std::optional<double> typical_depth(const Dataset& data) {
  const std::vector<Camera> cameras = spread_cameras(cameras_of(data.train), kMostCameras);
  if (data.points.empty()) return median_or_none(depths_of_focus(cameras));
  std::vector<double> depths;
  for (const Camera& camera : cameras)
    if (const auto depth = depth_of_points(camera, data.points)) depths.push_back(*depth);
  return median_or_none(std::move(depths));
}

std::vector<std::string> scale_warnings(const Dataset& data) {
  const auto depth = typical_depth(data);
  if (!depth) return {};
  std::vector<double> distances, focal_lengths;
  for (const Photo& photo : data.train) {
    distances.push_back(glm::length(photo.camera.center()));
    focal_lengths.push_back(photo.camera.fx);
  }
  const double distance = median(std::move(distances));
  const double pixels = rounding_at(distance) / *depth * median(std::move(focal_lengths));
  std::vector<std::string> lines;
  if (pixels > kMostPixels)
    lines.push_back(fmt::format(
        "the cameras are {:.3g} units from the origin and {:.3g} from what they see, where numbers "
        "of 32 bits are wrong by up to {:.2g} pixels; move the poses to the origin",
        distance, *depth, pixels));
  const double near = RenderOptions().near_plane;
  if (*depth < kLeastNearPlanes * near)
    lines.push_back(fmt::format(
        "what the cameras see is {:.3g} units away, and nothing within {:g} is drawn; scale the "
        "poses up",
        *depth, near));
  return lines;
}

}  // namespace fluxgs
