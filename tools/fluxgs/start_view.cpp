#include "tools/fluxgs/start_view.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "camera/up_axis.h"
#include "camera/view_state.h"
#include "fluxgs/io/file.h"

namespace fluxgs::cli {

namespace {

/// The image that the others were taken around: from the edge of a capture, half of the ways to
/// turn lead to where nothing was seen.
const View& middle_one(const std::vector<View>& views) {
  const auto distances = [&](const View& view) {
    double sum = 0;
    for (const View& other : views)
      sum += glm::distance(view.camera.center(), other.camera.center());
    return sum;
  };
  const View* best = &views.front();
  double least = distances(*best);
  for (const View& view : views) {
    const double sum = distances(view);
    if (sum < 0.999 * least) best = &view, least = sum;  // around in a circle: the first
  }
  return *best;
}

}  // namespace

StartView start_view_of(const std::vector<View>& views) {
  const camera::ViewState view = camera::view_of(middle_one(views).camera, 1);
  return {.position = camera::eye(view),
          .orientation = view.orientation,
          .fov_y = view.fov,
          .up = camera::up_of_cameras(cameras_of(views)).direction};
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
