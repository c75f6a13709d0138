#include "tools/fluxgs/commands/meant_scene.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fluxgs/io/scene.h"
#include "tools/fluxgs/commands/train_run.h"
#include "trainer/data/file_list.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/pose_places.h"
#include "trainer/data/walk_folder.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;

bool has_scene_name(const fs::path& file) {
  return std::ranges::any_of(scene_formats(), [&](const SceneFormat& format) {
    return !format.extension.empty() && file.string().ends_with(format.extension);
  });
}

/// Scenes in a folder and the three levels below it, the largest first.
FileList scenes_below(const fs::path& folder) {
  constexpr int kDeepest = 3;
  std::vector<std::pair<std::uintmax_t, std::string>> found;
  walk_folder(folder, [&](const fs::directory_entry& entry, int depth) {
    std::error_code ignored;
    if (entry.is_regular_file(ignored) && has_scene_name(entry.path()))
      found.emplace_back(entry.file_size(ignored),
                         entry.path().lexically_relative(folder).string());
    return depth < kDeepest;
  });
  std::ranges::sort(found, std::greater());
  FileList names;
  for (const auto& [bytes, name] : found) names.add(name);
  return names;
}

/// Photos with poses, which may have a .ply of points beside them, or photos without scenes.
bool is_data_set(const fs::path& folder, const FileList& scenes) {
  if (!pose_places(folder).empty()) return true;
  if (!scenes.empty()) return false;
  const PhotoList photos = list_photos(folder);
  return !photos.photos.empty() || !photos.videos.empty();
}

}  // namespace

Expected<std::string> meant_scene(const std::string& path) {
  std::error_code ignored;
  const fs::path folder = path;
  if (!fs::is_directory(folder, ignored)) return path;
  for (const char* name : {"meta.json", "lod-meta.json"})
    if (fs::is_regular_file(folder / name, ignored)) return (folder / name).string();
  const FileList scenes = scenes_below(folder);
  if (is_data_set(folder, scenes))
    return fail(path, "",
                fmt::format("is a folder of photos, expected a scene; fluxgs train {} -o scene.glb "
                            "makes one",
                            typed(path)));
  if (scenes.empty()) return fail(path, "", "is a folder without a scene; expected a scene file");
  return fail(path, "", "is a folder, expected a scene file; in it: " + scenes.text());
}

}  // namespace fluxgs::cli
