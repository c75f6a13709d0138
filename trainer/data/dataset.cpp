#include "trainer/data/dataset.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <glm/geometric.hpp>

#include "trainer/data/colmap_model.h"
#include "trainer/data/colmap_source.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/find_masks.h"
#include "trainer/data/fit_images.h"
#include "trainer/data/holdout.h"
#include "trainer/data/lens_check.h"
#include "trainer/data/load_views.h"
#include "trainer/data/meant_folder.h"
#include "trainer/data/outliers.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/photos/photos_source.h"
#include "trainer/data/pose_places.h"
#include "trainer/data/recentre.h"
#include "trainer/data/reduction.h"
#include "trainer/data/source.h"
#include "trainer/data/transforms_source.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

constexpr double kLargestFactor = 64;  // times, for the images of a scene's training
constexpr std::size_t kFewImages = 5;

struct Found {
  std::string kind;
  Source source;
  fs::path folder;  ///< where masks and lists of test images may lie, too
};

Expected<Found> named(std::string kind, Expected<Source> source, const fs::path& folder) {
  if (!source) return std::unexpected(source.error());
  return Found{std::move(kind), std::move(*source), folder};
}

/// The poses of one place of a folder; of several COLMAP models those of the one with most images.
Expected<Found> read_place(const PosePlace& place, const fs::path& folder) {
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
Expected<Found> read_places(const std::vector<PosePlace>& places, const fs::path& folder) {
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
Expected<std::optional<Found>> read_poses_of_photos(const fs::path& given) {
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

/// `given` is the folder, or a .json file in it.
Expected<Found> read_source(const fs::path& folder, const fs::path& given,
                            const LoadOptions& options) {
  if (is_file(given) && given.extension() == ".json")
    return read_place(transforms_place(given), folder);
  if (const auto places = pose_places(folder); !places.empty()) return read_places(places, folder);
  auto above = read_poses_of_photos(folder);
  if (!above) return std::unexpected(above.error());
  if (*above) return std::move(**above);
  tell_of_other_poses(folder);
  auto photos = read_photos_source(folder, options.video_frames, options.steps);
  if (!photos) return std::unexpected(photos.error());
  return Found{std::move(photos->kind), std::move(photos->source), folder};
}

struct LoadedViews {
  std::vector<View> train, test;
};

/// The images of all frames; those that fail are left out and counted. An error where half of them
/// fail or no training image is left: that is not one bad image of many.
Expected<LoadedViews> load_all(Source& source, const LoadOptions& options) {
  const std::size_t train_count = source.frames.size();
  std::vector<SourceFrame> frames = std::move(source.frames);
  frames.insert(frames.end(), source.test_frames.begin(), source.test_frames.end());
  auto loaded = load_views(frames, options);
  LoadedViews views;
  FailedImages bad;
  FileList masked;
  for (std::size_t i = 0; i < loaded.size(); ++i) {
    if (loaded[i] && is_masked_whole(*loaded[i])) {
      masked.add(frames[i].file.string());
      continue;
    }
    if (loaded[i]) {
      (i < train_count ? views.train : views.test).push_back(std::move(*loaded[i]));
      continue;
    }
    bad.add(frames[i].file.string(), loaded[i].error());
  }
  const bool none_left = views.train.empty() && masked.empty();
  if (2 * bad.size() >= loaded.size() || none_left) return bad.failure(loaded.size());
  source.skipped_images += bad.size() + masked.size();
  bad.warn(source.warnings);
  if (masked.empty()) return views;
  const std::string which = "masked or transparent everywhere: " + masked.text();
  if (views.train.empty())
    return fail("", "masks", "no photo is left, they are " + which + "; white is what counts");
  source.warnings.push_back("left out, since they are " + which);
  return views;
}

/// One line about a capture that shows no depth, or hardly any.
void warn_of_no_parallax(Source& source) {
  std::vector<glm::dvec3> places;
  for (const auto* frames : {&source.frames, &source.test_frames})
    for (const SourceFrame& frame : *frames) places.push_back(camera_position(frame));
  const auto is_here = [&](const glm::dvec3& p) {
    constexpr double kRounding = 1e-9;
    return glm::distance(p, places[0]) <= kRounding * (1 + glm::length(places[0]));
  };
  if (places.size() == 1)
    source.warnings.push_back(
        "one image only: it shows no depth, and what is trained will look right from its place "
        "alone");
  else if (std::ranges::all_of(places, is_here))
    source.warnings.push_back(
        "all cameras are in one place: the images show no depth, and what is trained will look "
        "right from there alone; walk while you take photos");
  else if (places.size() < kFewImages)
    source.warnings.push_back(
        fmt::format("{} images only: what is trained will look right near their places alone; take "
                    "20 or more",
                    places.size()));
}

/// One line where images are reduced that nobody asked to reduce.
void tell_of_reduction(const Source& source, int downscale) {
  for (const SourceFrame& frame : source.frames) {
    const ImageSize stored{frame.lens.width, frame.lens.height};
    const ImageSize reduced = reduced_size(stored, downscale);
    if (downscale != 0 || reduced.width == stored.width) continue;
    spdlog::info("images of {}x{} are reduced to {}x{} (--downscale 1 keeps them as they are)",
                 stored.width, stored.height, reduced.width, reduced.height);
    return;
  }
}

/// One line about the masks of a capture that has some, or lacks those that were asked for.
void tell_of_masks(Dataset& data, MaskUse use) {
  std::size_t all = 0, ignoring = 0, carving = 0;
  for (const auto* views : {&data.train, &data.test})
    for (const View& view : *views)
      ++all, ignoring += !view.used.pixels.empty(), carving += !view.alpha.pixels.empty();
  if (ignoring > 0)
    spdlog::info("{} of {} photos have {}; training ignores these parts", ignoring, all,
                 use == MaskUse::ignore ? "masked or transparent parts" : "masked parts");
  if (carving > 0)
    spdlog::info("{} of {} photos have {}; the scene stays empty there", carving, all,
                 use == MaskUse::carve ? "black or transparent parts" : "transparent parts");
  if (ignoring + carving == 0 && (use == MaskUse::ignore || use == MaskUse::carve))
    data.warnings.push_back(
        "--masks has no effect: no photo has a mask or transparent parts; expected masks/ beside "
        "the photos, with photo.jpg.png or photo.png for photo.jpg");
}

/// The factor to reduce images by; of a scene's training, where nothing else is asked for.
int reduction_factor(const Source& source, const LoadOptions& options) {
  const bool asked = options.downscale != 0 || options.trained_side <= 0;
  if (asked || source.frames.empty()) return options.downscale;
  const Lens& lens = source.frames.front().lens;
  const ImageSize unasked = reduced_size({lens.width, lens.height}, 0);
  const int side = std::max(unasked.width, unasked.height);
  const double factor =
      std::round(std::max(lens.width, lens.height) / static_cast<double>(options.trained_side));
  if (std::abs(side - options.trained_side) <= side / 10 || factor < 1 || factor > kLargestFactor)
    return 0;
  spdlog::info("images reduced by {}, as the scene was trained (--downscale 1 for all pixels)",
               factor);
  return static_cast<int>(factor);
}

Expected<void> check_options(const LoadOptions& options) {
  if (options.downscale < 0)
    return fail("", "downscale", fmt::format("{}, expected 0 or more", options.downscale));
  if (options.test_every.value_or(0) < 0)
    return fail("", "test_every", fmt::format("{}, expected 0 or more", *options.test_every));
  return {};
}

}  // namespace

bool is_masked_whole(const View& view) {
  const auto black = [](const Image<std::uint8_t>& mask) {
    return !mask.pixels.empty() && std::ranges::all_of(mask.pixels, [](auto v) { return v == 0; });
  };
  return black(view.used) || black(view.alpha);
}

std::vector<Camera> cameras_of(const std::vector<View>& views) {
  std::vector<Camera> cameras;
  for (const View& view : views) cameras.push_back(view.camera);
  return cameras;
}

std::vector<Camera> spread_cameras(const std::vector<Camera>& cameras, std::size_t count) {
  std::vector<Camera> chosen;
  const std::size_t all = cameras.size(), most = std::min(all, count);
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(cameras[(2 * i + 1) * all / (2 * most)]);
  return chosen;
}

Expected<Dataset> load_dataset(const fs::path& given, const LoadOptions& options) {
  const auto meant = meant_folder(given);
  if (!meant) return std::unexpected(meant.error());
  const fs::path& folder = *meant;
  if (const auto ok = check_options(options); !ok) return std::unexpected(ok.error());
  std::error_code error;
  const auto status = fs::status(folder, error);
  if (!fs::exists(status)) return fail(folder.string(), "", "no such folder");
  if (!fs::is_directory(status) && !is_video_name(folder))
    return fail(folder.string(), "", "neither a folder with images nor a video (.mp4, .mov, ...)");

  auto found = read_source(folder, given, options);
  if (!found) return std::unexpected(found.error());
  Source& source = found->source;
  if (options.masks != MaskUse::off) find_masks(source, found->folder);
  fit_to_images(source);
  remove_outliers(source);
  warn_of_lenses(source);
  recentre(source);
  LoadOptions how = options;
  how.downscale = reduction_factor(source, options);
  if (const auto ok = remove_too_small(source, how.downscale); !ok)
    return std::unexpected(ok.error());
  if (const auto ok = hold_out(source, found->folder, options); !ok)
    return std::unexpected(ok.error());
  if (source.frames.empty())
    return fail(folder.string(), "",
                fmt::format("no training images: {} left out, {} for testing{}{}",
                            source.skipped_images, source.test_frames.size(),
                            source.warnings.empty() ? "" : "; ", fmt::join(source.warnings, "; ")));
  warn_of_no_parallax(source);
  tell_of_reduction(source, how.downscale);

  auto views = load_all(source, how);
  if (!views) return std::unexpected(views.error());
  Dataset dataset{.kind = found->kind,
                  .train = std::move(views->train),
                  .test = std::move(views->test),
                  .points = {source.points.begin(), source.points.end()},
                  .point_colors = std::move(source.point_colors),
                  .points_file = std::move(source.points_file),
                  .skipped_images = source.skipped_images,
                  .warnings = std::move(source.warnings)};
  spdlog::info("{}: {}, {} training and {} test images of {}x{}, {} sparse points", folder.string(),
               dataset.kind, dataset.train.size(), dataset.test.size(),
               dataset.train[0].camera.width, dataset.train[0].camera.height,
               dataset.points.size());
  tell_of_masks(dataset, options.masks);
  return dataset;
}

}  // namespace fluxgs
