#include "tools/fluxgs/start_view.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "camera/up_axis.h"
#include "camera/view_state.h"
#include "fluxgs/io/file.h"

namespace fluxgs::cli {

namespace {

/// The photo that the others were taken around: from the edge of a capture, half of the ways to
/// turn lead to where nothing was seen.
const Photo& middle_one(const std::vector<Photo>& photos) {
  const auto distances = [&](const Photo& photo) {
    double sum = 0;
    for (const Photo& other : photos)
      sum += glm::distance(photo.camera.center(), other.camera.center());
    return sum;
  };
  const Photo* best = &photos.front();
  double least = distances(*best);
  for (const Photo& photo : photos) {
    const double sum = distances(photo);
    if (sum < 0.999 * least) best = &photo, least = sum;  // around in a circle: the first
  }
  return *best;
}

}  // namespace

StartView start_view_of(const std::vector<Photo>& photos) {
  const camera::ViewState view = camera::view_of(middle_one(photos).camera, 1);
  return {.position = camera::eye(view),
          .orientation = view.orientation,
          .fov_y = view.fov,
          .up = camera::up_of_cameras(cameras_of(photos)).direction};
}

Expected<std::size_t> write_glb(const std::filesystem::path& path,
                                const std::vector<std::byte>& glb,
                                const std::optional<StartView>& start) {
  const auto file =
      start ? with_start_view(glb, *start, path.string()) : Expected<std::vector<std::byte>>(glb);
  if (!file) return std::unexpected(file.error());
  if (auto written = write_file_atomic(path, *file); !written)
    return std::unexpected(written.error());
  return file->size();
}

}  // namespace fluxgs::cli
