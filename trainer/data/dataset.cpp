#include "trainer/data/dataset.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <glm/geometric.hpp>

#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/find_masks.h"
#include "trainer/data/find_source.h"
#include "trainer/data/fit_images.h"
#include "trainer/data/holdout.h"
#include "trainer/data/lens_check.h"
#include "trainer/data/load_views.h"
#include "trainer/data/meant_folder.h"
#include "trainer/data/outliers.h"
#include "trainer/data/photo_memory.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/recentre.h"
#include "trainer/data/reduction.h"
#include "trainer/data/source.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

constexpr double kLargestFactor = 64;  // times, for the images of a scene's training
constexpr std::size_t kFewImages = 5;

struct LoadedViews {
  std::vector<View> train, test;
};

/// The images of all frames; those that fail are left out and counted. An error where half of them
/// fail or no training image is left: that is not one bad image of many.
Expected<LoadedViews> load_all(Source& source, const LoadOptions& options) {
  const std::size_t train_count = source.frames.size();
  std::vector<SourceFrame> frames = std::move(source.frames);
  frames.insert(frames.end(), source.test_frames.begin(), source.test_frames.end());
  PhotoMemory memory(options.max_photo_bytes);
  auto loaded = load_views(frames, options, memory);
  if (!memory.full().empty()) return fail("", "", memory.full());  // not a fault of some photos
  if (memory.in_files() > 0)
    spdlog::info(
        "{:.0f} MB of pixels lie in a temporary file, since photos may take {:.0f} MB of "
        "memory (--photo-memory, --downscale)",
        1e-6 * static_cast<double>(memory.in_files()), 1e-6 * static_cast<double>(memory.limit()));
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
  const std::vector<glm::dvec3> places = camera_positions(source);
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

std::vector<std::uint32_t> spread_indices(std::size_t all, std::size_t count, double turn) {
  const std::size_t most = std::min(all, count);
  const double step = most > 0 ? static_cast<double>(all) / static_cast<double>(most) : 0;
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < most; ++i)
    chosen.push_back(static_cast<std::uint32_t>(
        std::min((static_cast<double>(i) + turn) * step, static_cast<double>(all) - 1)));
  return chosen;
}

std::vector<Camera> spread_cameras(const std::vector<Camera>& cameras, std::size_t count) {
  std::vector<Camera> chosen;
  for (const std::uint32_t i : spread_indices(cameras.size(), count)) chosen.push_back(cameras[i]);
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

  auto found = find_source(folder, given, options);
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
