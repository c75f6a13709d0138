#include "trainer/data/colmap_source.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fluxgs/sanitize.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/image_finder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Rotation and translation of an image; nothing if they are none.
std::optional<SourceFrame> posed_frame(const ColmapImage& image) {
  const glm::dquat& q = image.rotation;
  const glm::dvec3& t = image.translation;
  const double largest = std::max({std::abs(q.w), std::abs(q.x), std::abs(q.y), std::abs(q.z)});
  const double sum = q.w + q.x + q.y + q.z + t.x + t.y + t.z;
  if (!std::isfinite(sum) || largest < 1e-100) return std::nullopt;
  SourceFrame frame{.file = {}, .name = image.name, .lens = {}};
  frame.rotation = glm::mat3_cast(glm::normalize(q / largest));
  frame.translation = t;
  return frame;
}

Expected<Lens> lens_of(const ColmapImage& image, const ColmapModel& model,
                       const std::string& file) {
  const auto camera = model.cameras.find(image.camera_id);
  if (camera != model.cameras.end()) return camera->second;
  return fail(file, fmt::format("image \"{}\"", one_line(image.name)),
              fmt::format("camera {} is not in the model's list of cameras", image.camera_id));
}

Expected<void> add_points(const ColmapModel& model, const fs::path& folder, Source& source) {
  const fs::path ply = folder / "points3D.ply";
  if (!model.has_points_file && is_file(ply)) return add_ply_points(ply, source);
  if (!model.has_points_file)
    source.warnings.push_back(folder.string() + ": the model has no points3D file");
  std::size_t dropped = 0;
  for (const ColmapPoint& p : model.points) dropped += !add_point(source, p.position, p.color);
  if (dropped > 0)
    source.warnings.push_back(
        fmt::format("{}: {} points that are not finite were dropped", folder.string(), dropped));
  return {};
}

/// The files of the images; those that two images would share belong to neither.
std::map<std::string, fs::path> find_files(const ColmapModel& model,
                                           const std::vector<fs::path>& folders, FileList& shared) {
  std::vector<std::string> names;
  for (const ColmapImage& image : model.images) names.push_back(image.name);
  const ImageFinder finder(folders, names);
  std::map<std::string, fs::path> files;
  std::map<fs::path, int> uses;
  for (const std::string& name : names)
    if (const auto file = finder.find(name)) files[name] = *file, ++uses[*file];
  for (const std::string& name : names) {
    const auto file = files.find(name);
    if (file == files.end() || uses[file->second] == 1) continue;
    shared.add(name);
    files.erase(file);
  }
  return files;
}

/// Those that an image must have, and have once.
Expected<void> check_names(const ColmapModel& model, const std::string& file) {
  std::set<std::string> names;
  for (const ColmapImage& image : model.images) {
    if (image.name.empty()) return fail(file, "", "an image without a name");
    if (!names.insert(image.name).second)
      return fail(file, fmt::format("image \"{}\"", one_line(image.name)),
                  "listed twice, expected every image once");
  }
  return {};
}

std::string text_of(const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  for (const fs::path& folder : folders) names.push_back(folder.string());
  return fmt::format("{}", fmt::join(names, " or "));
}

}  // namespace

Expected<Source> read_colmap_source(const fs::path& model_folder,
                                    const std::vector<fs::path>& image_folders) {
  auto model = read_colmap_model(model_folder);
  if (!model) return std::unexpected(model.error());
  const bool binary = is_binary_model(model_folder);
  const std::string file = (model_folder / (binary ? "images.bin" : "images.txt")).string();
  if (const auto ok = check_names(*model, file); !ok) return std::unexpected(ok.error());

  Source source;
  source.warnings = std::move(model->warnings);
  if (model->images.empty()) source.warnings.push_back(file + ": lists no images");
  FileList shared, missing, without_pose;
  const auto files = find_files(*model, image_folders, shared);
  for (const ColmapImage& image : model->images) {
    const auto lens = lens_of(image, *model, file);
    if (!lens) return std::unexpected(lens.error());
    auto frame = posed_frame(image);
    const auto path = files.find(image.name);
    if (!frame || path == files.end()) {
      (frame ? missing : without_pose).add(image.name);
      continue;
    }
    frame->file = path->second;
    frame->lens = *lens;
    source.frames.push_back(std::move(*frame));
  }
  source.skipped_images = missing.size() + without_pose.size();
  if (!shared.empty())
    source.warnings.push_back(fmt::format(
        "{}: {} images would have the same file as another; which one has it is not known: {}",
        file, shared.size(), shared.text()));
  if (missing.size() > shared.size())
    source.warnings.push_back(
        fmt::format("{}: {} of {} images have no file in {} and are skipped: {}", file,
                    missing.size(), model->images.size(), text_of(image_folders), missing.text()));
  if (!without_pose.empty())
    source.warnings.push_back(fmt::format(
        "{}: {} images have no pose (not finite, or a rotation of zeros) and are skipped: {}", file,
        without_pose.size(), without_pose.text()));
  if (const auto ok = add_points(*model, model_folder, source); !ok)
    return std::unexpected(ok.error());
  return source;
}

}  // namespace fluxgs
