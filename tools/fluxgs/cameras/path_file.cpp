#include "tools/fluxgs/cameras/path_file.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "fluxgs/io/file.h"

namespace fluxgs::cli {
namespace {

constexpr std::size_t kMostBytes = 16u << 20;
constexpr double kLegSeconds = 3, kMostFrames = 10'000;

bool is_list(const std::vector<std::byte>& bytes) {
  for (const std::byte b : bytes)
    if (const char c = static_cast<char>(b); c != ' ' && c != '\n' && c != '\r' && c != '\t')
      return c == '[';
  return false;
}

/// The cameras have no targets: they are as far away as the next camera.
camera::CameraPath path_along(const std::vector<Camera>& cameras) {
  double way = 0;
  for (std::size_t i = 1; i < cameras.size(); ++i)
    way += glm::distance(cameras[i - 1].center(), cameras[i].center());
  const auto legs = static_cast<double>(std::max<std::size_t>(cameras.size() - 1, 1));
  std::vector<camera::ViewState> views;
  for (const Camera& camera : cameras)
    views.push_back(camera::view_of(camera, way > 0 ? way / legs : 1));
  return camera::path_through(views, false, kLegSeconds * legs);
}

}  // namespace

Expected<camera::CameraPath> path_from_file(const std::string& path) {
  const auto bytes = read_file(path, kMostBytes);
  if (!bytes) return std::unexpected(bytes.error());
  if (is_list(*bytes)) {
    const auto cameras = cameras_from_file(path, {1, 1});
    if (!cameras) return std::unexpected(cameras.error());
    return path_along(*cameras);
  }
  const auto track = read_supersplat_track(*bytes, path);
  if (!track) return std::unexpected(track.error());
  return camera::path_of(*track);
}

Expected<std::vector<Camera>> cameras_along(const camera::CameraPath& path, double fps,
                                            const ImageSize& size) {
  const double frames = std::ceil(path.seconds * fps - 1e-9);
  const bool repeats = path.end == camera::PathEnd::repeats;
  const double count = std::max(frames + (repeats ? 0 : 1), 1.0);
  if (count > kMostFrames)
    return fail("", "",
                fmt::format("the path has {:.0f} frames at {} a second; expected at most {}", count,
                            fps, kMostFrames));
  std::vector<Camera> cameras;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    const camera::ViewState view = camera::view_at(path, i / fps, {size.width, size.height});
    cameras.push_back(camera::camera_of(view, size.width, size.height));
    cameras.back().name = fmt::format("{:03}", i);
  }
  return cameras;
}

}  // namespace fluxgs::cli
