#include "tools/fluxgs/commands/command.h"

#include <spdlog/spdlog.h>

#include "fluxgs/io/file.h"

namespace fluxgs::cli {

Expected<SceneFile> load_scene(const std::string& path) {
  auto scene = read_scene(path);
  if (!scene) return scene;
  for (const std::string& warning : scene->warnings) spdlog::warn("warning: {}: {}", path, warning);
  if (scene->dropped > 0)
    spdlog::warn("warning: {}: {} splats with NaN or infinity left out", path, scene->dropped);
  if (scene->cloud.size() == 0) spdlog::warn("warning: {}: has no splats", path);
  return scene;
}

void warn_of_lost_degrees(const std::string& path, const SceneFormat& format, int sh_degree) {
  if (sh_degree <= format.max_sh_degree) return;
  spdlog::warn(
      "warning: {}: a {} stores spherical harmonics up to degree {}; those up to {} are "
      "left out",
      path, format.extension, format.max_sh_degree, sh_degree);
}

Expected<std::size_t> write_glb(const std::string& path, const std::vector<std::byte>& glb,
                                const std::optional<InitialView>& initial) {
  const auto file =
      initial ? with_initial_view(glb, *initial, path) : Expected<std::vector<std::byte>>(glb);
  if (!file) return std::unexpected(file.error());
  if (auto written = write_file_atomic(path, *file); !written)
    return std::unexpected(written.error());
  return file->size();
}

}  // namespace fluxgs::cli
