#include "trainer/data/photos/photos_source.h"

#include <algorithm>
#include <map>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "trainer/data/colmap_model.h"
#include "trainer/data/colmap_source.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/photos/colmap_program.h"
#include "trainer/data/photos/colmap_state.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/photos/prepare_photos.h"
#include "trainer/data/photos/run_colmap.h"
#include "trainer/data/photos/video_frames.h"
#include "trainer/data/photos/work_folder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Photos of a folder or, if it has none, its only video.
struct Input {
  std::vector<Photo> photos;
  std::optional<fs::path> video;
};

std::unexpected<Error> no_photos(const fs::path& folder, const PhotoList& list) {
  if (!list.raw.empty())
    return fail(folder.string(), "",
                fmt::format("{} raw files like {} cannot be read; export them as JPEG",
                            list.raw.size(), list.raw.front().filename().string()));
  if (!list.videos.empty())
    return fail(folder.string(), "",
                fmt::format("holds {} videos; name the one to train on, like {}",
                            list.videos.size(), list.videos.front().string()));
  return fail(
      folder.string(), "",
      "no data set here; expected a COLMAP model (sparse/0), transforms.json, images (.jpg, "
      ".png, .webp, .heic, .avif, .tif, .bmp), or a video");
}

Expected<Input> find_input(const fs::path& given, std::vector<std::string>& warnings) {
  if (is_file(given)) return Input{.photos = {}, .video = given};
  std::error_code ignored;
  const fs::path inner = given / "images";
  PhotoList list;
  if (fs::is_directory(inner, ignored)) list = list_photos(inner);
  const fs::path folder = list.photos.empty() ? given : inner;
  if (list.photos.empty()) list = list_photos(given);
  if (list.photos.empty() && list.videos.size() == 1)
    return Input{.photos = {}, .video = list.videos.front()};
  if (list.photos.empty()) return no_photos(folder, list);
  FileList other;
  for (const auto* files : {&list.videos, &list.raw})
    for (const fs::path& file : *files) other.add(file.filename().string());
  if (!other.empty())
    warnings.push_back(fmt::format("{}: videos and raw files beside photos are not used: {}",
                                   folder.string(), other.text()));
  return Input{.photos = std::move(list.photos), .video = {}};
}

/// Clears the work folder, but not its lock, which is held.
void forget_all(const fs::path& work) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(work, ignored))
    if (entry.path().filename() != "lock") fs::remove_all(entry.path(), ignored);
}

/// Replaces the video by its frames.
Expected<void> take_frames(Input& input, int count, const fs::path& work, ColmapState& state,
                           const StepReport& report, std::vector<std::string>& warnings) {
  std::error_code ignored;
  const std::uint64_t bytes = fs::file_size(*input.video, ignored);
  if (count == 0) count = state.video_frames > 0 ? state.video_frames : kDefaultVideoFrames;
  const fs::path frames = work / "photos";
  const bool there = fs::is_directory(frames, ignored) && state.video_bytes == bytes &&
                     state.video_frames == count;
  if (!there) {
    forget_all(work);
    state = {};
    state.video_bytes = bytes;
    state.video_frames = count;
    if (auto ok = extract_video_frames(*input.video, count, frames, report, warnings); !ok)
      return ok;
    if (auto ok = write_colmap_state(work, state); !ok) return ok;
  }
  input.photos = list_photos(frames).photos;
  return {};
}

/// Notes the photos; starts all over where one of them is another than before.
Expected<void> note_photos(const std::vector<Photo>& photos, const fs::path& work,
                           ColmapState& state) {
  std::size_t added = 0;
  bool changed = false;
  for (const Photo& photo : photos) {
    const auto known = state.photos.find(photo.name);
    added += known == state.photos.end();
    changed = changed || (known != state.photos.end() && known->second != photo.bytes);
  }
  if (changed) {
    spdlog::info("photos have changed; their poses are found anew");
    forget_all(work);
    state = {};
  } else if (added > 0 && !state.mapped.empty()) {
    spdlog::info("{} photos are new; the others keep their features", added);
  }
  for (const Photo& photo : photos) state.photos[photo.name] = photo.bytes;
  return write_colmap_state(work, state);
}

bool is_mapped(const std::vector<Photo>& photos, const ColmapState& state, const fs::path& work) {
  return has_colmap_models(work / "sparse") &&
         std::ranges::all_of(photos, [&](const Photo& p) { return state.mapped.contains(p.name); });
}

/// Frames of the copies become those of the photos; photos without one are named.
void use_photos(const std::vector<PreparedPhoto>& prepared, Source& source) {
  std::map<std::string, const PreparedPhoto*> by_copy;
  for (const PreparedPhoto& photo : prepared) by_copy[photo.copy] = &photo;
  std::erase_if(source.frames, [&](SourceFrame& frame) {
    const auto found = by_copy.find(frame.name);
    if (found == by_copy.end()) return true;  // a photo that was taken away since
    const PreparedPhoto& photo = *found->second;
    frame.file = photo.photo.file;
    frame.name = photo.photo.name;
    frame.orientation = photo.orientation;
    by_copy.erase(found);
    return false;
  });
  FileList without;
  for (const PreparedPhoto& photo : prepared)
    if (by_copy.contains(photo.copy)) without.add(photo.photo.name);
  source.skipped_images += without.size();
  spdlog::info("COLMAP: {} of {} photos registered", source.frames.size(), prepared.size());
  if (!without.empty())
    source.warnings.push_back(
        fmt::format("COLMAP found no pose for {} of {} photos; they are left out: {}",
                    without.size(), prepared.size(), without.text()));
}

Expected<Source> read_poses(const std::vector<PreparedPhoto>& prepared, const fs::path& work) {
  const auto models = colmap_models(work / "sparse");
  if (models.empty()) return fail((work / "sparse").string(), "", "holds no COLMAP model");
  auto source = read_colmap_source(models.front().folder, {work / "images"});
  if (!source) return source;
  use_photos(prepared, *source);
  if (models.size() > 1)
    source->warnings.push_back(
        fmt::format("the photos fall into {} groups that COLMAP could not join; the largest, of {} "
                    "photos, is used, the next has {}",
                    models.size(), models[0].images, models[1].images));
  return source;
}

}  // namespace

bool holds_photos(const fs::path& input) {
  if (is_file(input)) return is_video_name(input);
  for (const fs::path& folder : {input, input / "images"}) {
    const PhotoList list = list_photos(folder);
    if (!list.photos.empty() || !list.videos.empty()) return true;
  }
  return false;
}

Expected<PhotosSource> read_photos_source(const fs::path& given, int video_frames,
                                          const StepReport& report) {
  std::vector<std::string> warnings;
  auto input = find_input(given, warnings);
  if (!input) return std::unexpected(input.error());
  if (!input->video && input->photos.size() < 2)
    return fail(input->photos.front().file.string(), "",
                "the only photo here; poses need two at least, and a scene some dozens");
  const auto work = work_folder_of(input->video ? *input->video : given);
  if (!work) return std::unexpected(work.error());
  ColmapState state = read_colmap_state(*work);
  if (state.mapped.empty())
    if (auto ok = check_colmap_installed(given); !ok) return std::unexpected(ok.error());
  const auto lock = WorkFolderLock::take(*work);
  if (!lock) return std::unexpected(lock.error());
  if (state.photos.empty() && state.video_bytes == 0) forget_all(*work);
  if (input->video)
    if (auto ok = take_frames(*input, video_frames, *work, state, report, warnings); !ok)
      return std::unexpected(ok.error());
  if (input->photos.size() < 2)
    return fail(input->video->string(), "", "a video of one frame shows no scene");
  if (auto ok = note_photos(input->photos, *work, state); !ok) return std::unexpected(ok.error());

  const bool done = is_mapped(input->photos, state, *work);
  if (!done)
    spdlog::info(
        "looking for the poses of {} photos with COLMAP, in {} (if interrupted, the same "
        "command goes on)",
        input->photos.size(), work->string());
  auto prepared = prepare_photos(input->photos, *work / "images", report, warnings);
  if (!prepared) return std::unexpected(prepared.error());
  if (!done) {
    if (auto ok = run_colmap(*prepared, *work, state, report); !ok)
      return std::unexpected(ok.error());
    for (const Photo& photo : input->photos) state.mapped.insert(photo.name);
    if (auto ok = write_colmap_state(*work, state); !ok) return std::unexpected(ok.error());
  }
  auto source = read_poses(*prepared, *work);
  if (!source) return std::unexpected(source.error());
  source->warnings.insert(source->warnings.begin(), warnings.begin(), warnings.end());
  return PhotosSource{input->video ? "video (COLMAP)" : "images (COLMAP)", std::move(*source)};
}

}  // namespace fluxgs
