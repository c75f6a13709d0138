#include "trainer/data/find_source.h"

#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "trainer/data/colmap_model.h"
#include "trainer/data/colmap_source.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/photos/photos_source.h"
#include "trainer/data/pose_places.h"
#include "trainer/data/transforms_source.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

Expected<FoundSource> named(std::string kind, Expected<Source> source, const fs::path& folder) {
  if (!source) return std::unexpected(source.error());
  return FoundSource{std::move(kind), std::move(*source), folder};
}

/// The poses of one place of a folder; of several COLMAP models those of the one with most images.
Expected<FoundSource> read_place(const PosePlace& place, const fs::path& folder) {
  if (place.kind == PosePlace::Kind::transforms)
    return named(place.path.filename().string(), read_transforms_source(place.path, place.images),
                 folder);
  if (place.kind == PosePlace::Kind::colmap_model)
    return named("COLMAP", read_colmap_source(place.path, place.images), folder);
  const auto models = colmap_models(place.path);
  if (models.empty()) return fail(place.path.string(), "", "holds no COLMAP model");
  auto found = named("COLMAP", read_colmap_source(models.front().folder, place.images), folder);
  if (found && models.size() > 1)
    found->source.warnings.push_back(fmt::format(
        "{}: the largest of {} models, with {} images; the next has {}",
        models.front().folder.string(), models.size(), models[0].images, models[1].images));
  return found;
}

bool has_frames(const Source& source) {
  return !source.frames.empty() || !source.test_frames.empty();
}

/// The first place, or a later one where none of the first one's images is there.
Expected<FoundSource> read_places(const std::vector<PosePlace>& places, const fs::path& folder) {
  auto first = read_place(places.front(), folder);
  if (!first || has_frames(first->source)) return first;
  for (std::size_t i = 1; i < places.size(); ++i) {
    auto other = read_place(places[i], folder);
    if (!other || !has_frames(other->source)) continue;
    other->source.warnings.push_back(fmt::format("{}: none of its images is there; {} is read",
                                                 places.front().path.string(),
                                                 places[i].path.string()));
    return other;
  }
  return first;
}

/// Poses above a folder of photos, of half of them or more. Nothing if there are none; an error of
/// theirs where the folder is called as that of a data set's images.
Expected<std::optional<FoundSource>> read_poses_of_photos(const fs::path& given) {
  const fs::path photos = fs::absolute(given / "").lexically_normal().parent_path();
  const std::size_t count = list_photos(photos).photos.size();
  for (const PosePlace& place : pose_places_of_photos(photos)) {
    auto found = read_place(place, photos.parent_path());
    if (!found && has_name_of_images(photos)) return std::unexpected(found.error());
    const std::size_t posed =
        found ? found->source.frames.size() + found->source.test_frames.size() : 0;
    if (posed == 0 || 2 * posed < count) continue;
    spdlog::info("{}: poses of {}", given.string(), place.path.string());
    return std::move(*found);
  }
  return std::nullopt;
}

/// One line where something looks like a data set whose poses cannot be read, before COLMAP looks
/// for them anew.
void tell_of_other_poses(const fs::path& folder) {
  for (const char* name :
       {"sparse/0/images.bin", "sparse/0/images.txt", "sparse/images.bin", "sparse/images.txt",
        "transforms_test.json", "transforms_val.json", "poses_bounds.npy",
        "keyframes/corrected_cameras", "keyframes/cameras", "cameras.json", "cameras.xml"}) {
    std::error_code ignored;
    if (!fs::exists(folder / name, ignored)) continue;
    spdlog::warn(
        "warning: {}: {} is no complete set of poses that can be read (COLMAP's cameras and "
        "images, "
        "or transforms.json); they are looked for anew",
        folder.string(), name);
    return;
  }
}

/// A folder of poses or images that is there but must not be read; others would be taken in its
/// place.
Expected<void> check_readable(const fs::path& data) {
  for (const char* name :
       {"", "images", "input", "sparse", "sparse/0", "colmap", "colmap/sparse", "colmap/sparse/0",
        "distorted", "distorted/sparse", "distorted/sparse/0"}) {
    const fs::path folder = *name ? data / name : data;
    std::error_code error;
    if (!fs::is_directory(folder, error)) continue;
    const fs::directory_iterator entries(folder, error);
    if (error == std::errc::permission_denied)
      return fail(folder.string(), "", "cannot be read: " + error.message());
  }
  return {};
}

}  // namespace

Expected<FoundSource> find_source(const fs::path& folder, const fs::path& given,
                                  const LoadOptions& options) {
  if (is_file(given) && given.extension() == ".json")
    return read_place(transforms_place(given), folder);
  if (auto ok = check_readable(folder); !ok) return std::unexpected(ok.error());
  if (const auto places = pose_places(folder); !places.empty()) return read_places(places, folder);
  auto above = read_poses_of_photos(folder);
  if (!above) return std::unexpected(above.error());
  if (*above) return std::move(**above);
  tell_of_other_poses(folder);
  auto photos = read_photos_source(folder, options.video_frames, options.steps);
  if (!photos) return std::unexpected(photos.error());
  return FoundSource{std::move(photos->kind), std::move(photos->source), folder};
}

}  // namespace fluxgs
