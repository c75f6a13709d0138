#include "trainer/data/meant_folder.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/pose_places.h"
#include "trainer/data/walk_folder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Fewer photos beside data sets are no capture of their own: a cover, a thumbnail.
constexpr std::ptrdiff_t kFewPhotos = 3;

std::ptrdiff_t count_photos(const fs::path& folder) {
  std::error_code error;
  return std::ranges::count_if(fs::directory_iterator(folder, error), [](const auto& entry) {
    std::error_code ignored;
    return entry.is_regular_file(ignored) && is_photo_name(entry.path());
  });
}

bool holds_poses(const fs::path& folder) { return !pose_places(folder).empty(); }

/// Folders with poses below a folder, in the order of their names; none below another one.
std::vector<fs::path> data_sets_below(const fs::path& folder) {
  constexpr int kDeepest = 2;  // folders between
  std::vector<fs::path> found;
  walk_folder(folder, [&](const fs::directory_entry& entry, int depth) {
    std::error_code ignored;
    if (!entry.is_directory(ignored)) return false;
    const bool poses = holds_poses(entry.path());
    if (poses) found.push_back(entry.path());
    const bool hidden = entry.path().filename().string().starts_with('.');
    return !poses && !hidden && depth < kDeepest;
  });
  std::ranges::sort(found);
  return found;
}

}  // namespace

Expected<fs::path> meant_folder(const fs::path& given) {
  std::error_code ignored;
  if (is_file(given) && given.extension() == ".json") return given.parent_path();
  if (!fs::is_directory(given, ignored) || holds_poses(given)) return given;
  if (count_photos(given) >= kFewPhotos || count_photos(given / "images") > 0) return given;
  const auto below = data_sets_below(given);
  if (below.empty()) return given;
  if (below.size() == 1) return below.front();
  FileList names;
  for (const fs::path& folder : below) names.add(folder.lexically_relative(given).string());
  return fail(
      given.string(), "",
      fmt::format("{} data sets lie below: {}; name one of them", below.size(), names.text()));
}

}  // namespace fluxgs
