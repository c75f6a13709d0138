#include "trainer/data/colmap_source.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/image_io.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Rotation and translation of an image into a frame; the error's field names the image.
Expected<void> set_pose(const ColmapImage& image, const std::string& file, SourceFrame& frame) {
  const std::string field = fmt::format("image \"{}\"", one_line(image.name));
  const glm::dquat& q = image.rotation;
  const glm::dvec3& t = image.translation;
  const double largest = std::max({std::abs(q.w), std::abs(q.x), std::abs(q.y), std::abs(q.z)});
  const bool finite = std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) &&
                      std::isfinite(q.z) && std::isfinite(t.x) && std::isfinite(t.y) &&
                      std::isfinite(t.z);
  if (!finite) return fail(file, field, "its pose is not finite, expected seven numbers");
  if (largest < 1e-100) return fail(file, field, "its rotation is the zero quaternion");
  frame.rotation = glm::mat3_cast(glm::normalize(q / largest));
  frame.translation = t;
  return {};
}

Expected<SourceFrame> make_frame(const ColmapImage& image, const ColmapModel& model,
                                 const fs::path& image_folder, const std::string& file) {
  const auto camera = model.cameras.find(image.camera_id);
  if (camera == model.cameras.end())
    return fail(file, fmt::format("image \"{}\"", one_line(image.name)),
                fmt::format("camera {} is not in the model's list of cameras", image.camera_id));
  SourceFrame frame{.file = image_folder / image.name, .name = image.name, .lens = camera->second};
  if (const auto ok = set_pose(image, file, frame); !ok) return std::unexpected(ok.error());
  return frame;
}

void add_points(const ColmapModel& model, const std::string& folder, Source& source) {
  if (!model.has_points_file)
    source.warnings.push_back(folder + ": the model has no points3D file");
  std::size_t dropped = 0;
  for (const ColmapPoint& p : model.points) dropped += !add_point(source, p.position, p.color);
  if (dropped > 0)
    source.warnings.push_back(
        fmt::format("{}: {} points that are not finite were dropped", folder, dropped));
}

}  // namespace

Expected<Source> read_colmap_source(const fs::path& model_folder, const fs::path& data_folder) {
  const auto model = read_colmap_model(model_folder);
  if (!model) return std::unexpected(model.error());
  const bool binary = is_file(model_folder / "cameras.bin");
  const std::string file = (model_folder / (binary ? "images.bin" : "images.txt")).string();
  const fs::path images = data_folder / "images";
  std::error_code ignored;
  const fs::path image_folder = fs::is_directory(images, ignored) ? images : data_folder;

  Source source;
  std::set<std::string> names;
  std::string first_missing;
  for (const ColmapImage& image : model->images) {
    if (image.name.empty()) return fail(file, "", "an image without a name");
    if (!names.insert(image.name).second)
      return fail(file, fmt::format("image \"{}\"", one_line(image.name)),
                  "listed twice, expected every image once");
    auto frame = make_frame(image, *model, image_folder, file);
    if (!frame) return std::unexpected(frame.error());
    if (is_file(frame->file)) {
      const auto size = read_image_size(frame->file);
      if (!size) return std::unexpected(size.error());
      auto odd = shape_warning(frame->lens, size->width, size->height, frame->file.string());
      if (!odd.empty()) source.warnings.push_back(std::move(odd));
      frame->lens = lens_for_image(frame->lens, size->width, size->height);
      source.frames.push_back(std::move(*frame));
    } else {
      if (source.skipped_images++ == 0) first_missing = frame->file.string();
    }
  }
  if (source.skipped_images > 0)
    source.warnings.push_back(fmt::format("{} of {} images have no file and are skipped; first: {}",
                                          source.skipped_images, model->images.size(),
                                          one_line(first_missing)));
  add_points(*model, model_folder.string(), source);
  return source;
}

}  // namespace fluxgs
