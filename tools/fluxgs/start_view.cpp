#include "tools/fluxgs/start_view.h"

#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "camera/up_axis.h"
#include "camera/view_state.h"
#include "fluxgs/io/file.h"

namespace fluxgs::cli {

StartView start_view_of(const std::vector<Photo>& photos) {
  const camera::ViewState view = camera::view_of(photos.front().camera, 1);
  return {.position = camera::eye(view),
          .orientation = view.orientation,
          .fov_y = view.fov_y,
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
