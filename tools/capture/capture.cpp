#include "tools/capture/capture.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <glm/exponential.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "tools/capture/occluder.h"
#include "tools/capture/shading.h"
#include "tools/capture/surface_points.h"
#include "trainer/data/image_io.h"

namespace fluxgs::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kBounces = 3;
constexpr const char* kPointsFile = "points3d.ply";

/// The light through sample i of the n×n of a pixel, in the display's linear range.
glm::vec3 sample_color(const Scene& scene, const Camera& camera, int x, int y, int i, int n) {
  const int column = i % n, row = i / n;
  const double px = x + (column + 0.5) / n, py = y + (row + 0.5) / n;
  const glm::dvec3 direction(
      glm::transpose(camera.rotation) *
      glm::dvec3((px - camera.cx) / camera.fx, (py - camera.cy) / camera.fy, 1.0));
  return tone_map(
      radiance(scene, glm::vec3(camera.center()), glm::vec3(glm::normalize(direction)), kBounces));
}

/// The mean of a pixel's samples: of one in each row and column first, and of all n×n only where
/// these differ visibly (edges, highlights, fine texture).
glm::vec3 pixel_color(const Scene& scene, const Camera& camera, int x, int y, int n) {
  constexpr float kVisible = 0.03F;  // of the square root of linear light, about as sRGB encodes it
  glm::vec3 sum(0), low(1), high(0);
  const auto first_column = [&](int row) { return (2 * row + 1) % (n | 1) % n; };
  for (int row = 0; row < n; ++row) {
    const glm::vec3 color = sample_color(scene, camera, x, y, row * n + first_column(row), n);
    sum += color;
    low = glm::min(low, color);
    high = glm::max(high, color);
  }
  const glm::vec3 contrast = glm::sqrt(high) - glm::sqrt(low);
  if (std::max({contrast.x, contrast.y, contrast.z}) < kVisible) return sum / static_cast<float>(n);
  for (int i = 0; i < n * n; ++i)
    if (i % n != first_column(i / n)) sum += sample_color(scene, camera, x, y, i, n);
  return sum / static_cast<float>(n * n);
}

/// The inverse of Camera's pose with OpenGL axes: y up, z backward.
nlohmann::json transform_matrix(const Camera& camera) {
  const glm::dmat3 to_world = glm::transpose(camera.rotation);
  const glm::dvec3 columns[] = {to_world[0], -to_world[1], -to_world[2], camera.center()};
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 3; ++r)
    rows.push_back({columns[0][r], columns[1][r], columns[2][r], columns[3][r]});
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

/// A list of frames, which may be empty; `c` has the intrinsics of all.
Expected<void> write_transforms(const fs::path& folder, const std::string& split, const Camera& c,
                                const std::vector<Camera>& cameras, bool points = false) {
  nlohmann::ordered_json json{{"camera_angle_x", 2 * std::atan(0.5 * c.width / c.fx)},
                              {"fl_x", c.fx},
                              {"fl_y", c.fy},
                              {"cx", c.cx},
                              {"cy", c.cy},
                              {"w", c.width},
                              {"h", c.height}};
  if (points) json["ply_file_path"] = kPointsFile;
  json["frames"] = nlohmann::ordered_json::array();
  for (const Camera& camera : cameras)
    json["frames"].push_back({{"file_path", fmt::format("./{}/{}", split, camera.name)},
                              {"transform_matrix", transform_matrix(camera)}});
  const std::string text = json.dump(1) + "\n";
  return write_file_atomic(folder / fmt::format("transforms_{}.json", split),
                           std::as_bytes(std::span(text)));
}

Expected<void> write_views(const fs::path& folder, const Scene& scene,
                           const std::vector<Camera>& cameras, int samples) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string(), "", "cannot be created: " + error.message());
  std::vector<Expected<void>> written(cameras.size());
  tbb::parallel_for(std::size_t{0}, cameras.size(), [&](std::size_t i) {
    written[i] =
        write_png(folder / (cameras[i].name + ".png"), render_view(scene, cameras[i], samples));
  });
  for (const auto& result : written)
    if (!result) return result;
  return {};
}

/// The training views with an occluder, and masks of it.
Expected<void> write_occluded_views(const fs::path& folder, const Scene& scene,
                                    const std::vector<Camera>& cameras,
                                    const CaptureOptions& options) {
  const fs::path masks = folder / "masks" / "train";
  std::error_code error;
  fs::create_directories(masks, error);
  if (error) return fail(masks.string(), "", "cannot be created: " + error.message());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Scene occluded = with_occluder(scene, cameras[i], options.seed + i);
    const std::string name = cameras[i].name + ".png";
    if (auto ok = write_views(folder / "train", occluded, {cameras[i]}, options.samples); !ok)
      return ok;
    if (auto ok = write_png(masks / name, occluder_mask(occluded, cameras[i])); !ok) return ok;
  }
  return {};
}

Expected<void> check(const CaptureOptions& o) {
  const auto range = [](const char* name, int value, int low, int high) -> Expected<void> {
    if (value >= low && value <= high) return {};
    return fail("", name, fmt::format("{}, expected {} to {}", value, low, high));
  };
  for (const auto& result :
       {range("width", o.width, 1, 8192), range("height", o.height, 1, 8192),
        range("train", o.train, 1, 999), range("test", o.test, 0, 999),
        range("samples", o.samples, 1, 16), range("points", o.points, 0, 5'000'000)})
    if (!result) return result;
  return {};
}

}  // namespace

Image<std::uint8_t> render_view(const Scene& scene, const Camera& camera, int samples) {
  Image<std::uint8_t> image(camera.width, camera.height, 3);
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const glm::vec3 color = pixel_color(scene, camera, x, y, samples);
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(255 * srgb_encode(color[c])));
    }
  });
  return image;
}

Expected<void> write_capture(const fs::path& folder, const CaptureOptions& options) {
  if (const auto ok = check(options); !ok) return ok;
  const Scene scene = make_scene(static_cast<std::uint32_t>(options.seed), options.scene);
  const CaptureCameras cameras = capture_cameras(options);
  const auto train = options.occluder
                         ? write_occluded_views(folder, scene, cameras.train, options)
                         : write_views(folder / "train", scene, cameras.train, options.samples);
  if (!train) return train;
  if (const auto ok = write_views(folder / "test", scene, cameras.test, options.samples); !ok)
    return ok;
  if (options.points > 0) {
    const std::string ply = surface_points_ply(scene, cameras.train, options.points, options.seed);
    if (auto ok = write_file_atomic(folder / kPointsFile, std::as_bytes(std::span(ply))); !ok)
      return ok;
  }
  // Last, so that an interrupted run leaves no folder that looks complete.
  if (const auto ok = write_transforms(folder, "test", cameras.train[0], cameras.test); !ok)
    return ok;
  return write_transforms(folder, "train", cameras.train[0], cameras.train, options.points > 0);
}

}  // namespace fluxgs::capture
