#include "trainer/data/colmap_source.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/image_finder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Where the images of a model are: images/, or input/ as the data sets of 3D Gaussian Splatting
/// call the photos that are not undistorted yet; or the data set's own folder.
std::vector<fs::path> folders_of_images(const fs::path& model, const fs::path& data) {
  const fs::path below = model.lexically_relative(data);
  const bool distorted = std::ranges::find(below, "distorted") != below.end();
  std::vector<fs::path> folders{data / "images", data / "input", data};
  if (distorted) std::swap(folders[0], folders[1]);
  return folders;
}

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

}  // namespace

Expected<Source> read_colmap_source(const fs::path& model_folder, const fs::path& data_folder) {
  auto model = read_colmap_model(model_folder);
  if (!model) return std::unexpected(model.error());
  const bool binary = is_binary_model(model_folder);
  const std::string file = (model_folder / (binary ? "images.bin" : "images.txt")).string();
  ImageFinder images(folders_of_images(model_folder, data_folder));

  Source source;
  source.warnings = std::move(model->warnings);
  if (model->images.empty()) source.warnings.push_back(file + ": lists no images");
  std::set<std::string> names;
  FileList missing, without_pose;
  for (const ColmapImage& image : model->images) {
    if (image.name.empty()) return fail(file, "", "an image without a name");
    if (!names.insert(image.name).second)
      return fail(file, fmt::format("image \"{}\"", one_line(image.name)),
                  "listed twice, expected every image once");
    const auto lens = lens_of(image, *model, file);
    if (!lens) return std::unexpected(lens.error());
    auto frame = posed_frame(image);
    const auto path = images.find(image.name);
    if (!frame || !path) {
      (frame ? missing : without_pose).add(image.name);
      continue;
    }
    frame->file = *path;
    frame->lens = *lens;
    source.frames.push_back(std::move(*frame));
  }
  source.skipped_images = missing.size() + without_pose.size();
  if (!missing.empty())
    source.warnings.push_back(
        fmt::format("{}: {} of {} images have no file below {} and are skipped: {}", file,
                    missing.size(), model->images.size(), data_folder.string(), missing.text()));
  if (!without_pose.empty())
    source.warnings.push_back(fmt::format(
        "{}: {} images have no pose (not finite, or a rotation of zeros) and are skipped: {}", file,
        without_pose.size(), without_pose.text()));
  if (const auto ok = add_points(*model, model_folder, source); !ok)
    return std::unexpected(ok.error());
  return source;
}

}  // namespace fluxgs
