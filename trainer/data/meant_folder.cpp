#include "trainer/data/meant_folder.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/pose_places.h"

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
  constexpr std::size_t kMost = 100'000;
  std::vector<fs::path> found;
  std::error_code error;
  const auto options = fs::directory_options::skip_permission_denied;
  std::size_t count = 0;
  for (fs::recursive_directory_iterator at(folder, options, error), end;
       !error && at != end && count < kMost; at.increment(error), ++count) {
    std::error_code ignored;
    if (!at->is_directory(ignored)) continue;
    const bool poses = holds_poses(at->path());
    if (poses) found.push_back(at->path());
    const bool hidden = at->path().filename().string().starts_with('.');
    if (poses || hidden || at.depth() >= kDeepest) at.disable_recursion_pending();
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace

Expected<fs::path> meant_folder(const fs::path& given) {
  std::error_code ignored;
  if (is_file(given) && given.extension() == ".json") return given.parent_path();
  if (!fs::is_directory(given, ignored) || holds_poses(given)) return given;
  const std::ptrdiff_t photos = count_photos(given);
  fs::path above = (fs::absolute(given).lexically_normal() / "..").lexically_normal();
  if (photos > 0 && holds_poses(above)) return above;
  if (photos >= kFewPhotos || count_photos(given / "images") > 0) return given;
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
