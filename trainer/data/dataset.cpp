#include "trainer/data/dataset.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "trainer/data/colmap_model.h"
#include "trainer/data/colmap_source.h"
#include "trainer/data/load_views.h"
#include "trainer/data/run_colmap.h"
#include "trainer/data/source.h"
#include "trainer/data/transforms_source.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

bool has_image_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png";
}

bool holds_views(const fs::path& folder) {
  std::error_code error;
  return std::ranges::any_of(fs::directory_iterator(folder, error), [](const auto& entry) {
    std::error_code ignored;
    return entry.is_regular_file(ignored) && has_image_extension(entry.path());
  });
}

/// The images of a folder without poses: those that COLMAP found earlier, or finds now.
Expected<Source> read_views_source(const fs::path& folder) {
  const fs::path work = folder / "colmap";
  auto model = largest_model(work / "sparse");
  if (!model) {
    const fs::path images = holds_views(folder / "images") ? folder / "images" : folder;
    if (!holds_views(images))
      return fail(folder.string(), "",
                  "no data set here; expected a COLMAP model (sparse/0), transforms.json, or "
                  "images (.jpg, .png)");
    if (const auto ok = run_colmap(images, work); !ok) return std::unexpected(ok.error());
    model = largest_model(work / "sparse");
  }
  if (!model) return fail((work / "sparse").string(), "", "holds no COLMAP model");
  return read_colmap_source(*model, folder);
}

struct Found {
  std::string kind;
  Source source;
};

Expected<Found> read_source(const fs::path& folder) {
  const auto named = [](std::string kind, Expected<Source> source) -> Expected<Found> {
    if (!source) return std::unexpected(source.error());
    return Found{std::move(kind), std::move(*source)};
  };
  for (const fs::path& model : {folder / "sparse" / "0", folder / "sparse", folder})
    if (is_colmap_model(model)) return named("COLMAP", read_colmap_source(model, folder));
  if (has_transforms(folder)) return named("transforms.json", read_transforms_source(folder));
  return named("images (COLMAP)", read_views_source(folder));
}

/// Every n-th frame of those sorted by name moves to the test split; a single frame stays.
void split(Source& source, int test_every) {
  const auto by_name = [](const SourceFrame& a, const SourceFrame& b) {
    return std::tie(a.name, a.file) < std::tie(b.name, b.file);
  };
  std::ranges::sort(source.frames, by_name);
  std::ranges::sort(source.test_frames, by_name);
  if (source.has_split || test_every == 0 || source.frames.size() < 2) return;
  std::vector<SourceFrame> train;
  for (std::size_t i = 0; i < source.frames.size(); ++i) {
    const bool test = i % static_cast<std::size_t>(test_every) == 0;
    (test ? source.test_frames : train).push_back(std::move(source.frames[i]));
  }
  source.frames = std::move(train);
}

Expected<void> check_options(const LoadOptions& options) {
  if (options.downscale < 1)
    return fail("", "downscale", fmt::format("{}, expected 1 or more", options.downscale));
  if (options.test_every < 0)
    return fail("", "test_every", fmt::format("{}, expected 0 or more", options.test_every));
  return {};
}

}  // namespace

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

Expected<Dataset> load_dataset(const fs::path& folder, const LoadOptions& options) {
  if (const auto ok = check_options(options); !ok) return std::unexpected(ok.error());
  std::error_code error;
  const auto status = fs::status(folder, error);
  if (!fs::exists(status)) return fail(folder.string(), "", "no such folder");
  if (!fs::is_directory(status))
    return fail(folder.string(), "", "not a folder, expected one with images and their poses");

  auto found = read_source(folder);
  if (!found) return std::unexpected(found.error());
  Source& source = found->source;
  split(source, options.test_every);
  if (source.frames.empty())
    return fail(folder.string(), "",
                fmt::format("no training images: {} listed without a file, {} for testing",
                            source.skipped_images, source.test_frames.size()));

  const auto train_count = static_cast<std::ptrdiff_t>(source.frames.size());
  std::vector<SourceFrame> frames = std::move(source.frames);
  frames.insert(frames.end(), source.test_frames.begin(), source.test_frames.end());
  auto views = load_views(frames, options);
  if (!views) return std::unexpected(views.error());
  const auto first_test = std::make_move_iterator(views->begin() + train_count);
  Dataset dataset{.kind = found->kind,
                  .train = {std::make_move_iterator(views->begin()), first_test},
                  .test = {first_test, std::make_move_iterator(views->end())},
                  .points = std::move(source.points),
                  .point_colors = std::move(source.point_colors),
                  .points_file = std::move(source.points_file),
                  .skipped_images = source.skipped_images,
                  .warnings = std::move(source.warnings)};
  spdlog::info("{}: {}, {} training and {} test images of {}x{}, {} sparse points", folder.string(),
               dataset.kind, dataset.train.size(), dataset.test.size(),
               dataset.train[0].camera.width, dataset.train[0].camera.height,
               dataset.points.size());
  return dataset;
}

}  // namespace fluxgs
