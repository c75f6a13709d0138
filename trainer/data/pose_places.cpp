#include "trainer/data/pose_places.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "trainer/data/colmap_model.h"
#include "trainer/data/transforms_source.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;
using Kind = PosePlace::Kind;

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// images/, or input/ as 3D Gaussian Splatting calls photos that are not undistorted yet, never
/// both: their images have the same names. Without either those that were made smaller.
std::vector<fs::path> image_folders(const fs::path& data, const char* first, const char* second) {
  for (const char* name : {first, second, "images_2", "images_4", "images_8"})
    if (is_folder(data / name)) return {data / name, data};
  return {data / first, data};
}

/// The same for a model that is itself the data set: in the nearest folder above with images.
std::vector<fs::path> image_folders_above(const fs::path& model) {
  fs::path folder = fs::absolute(model).lexically_normal();
  bool distorted = false;
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    if (is_folder(folder / "images") || is_folder(folder / "input"))
      return distorted ? image_folders(folder, "input", "images")
                       : image_folders(folder, "images", "input");
    distorted = distorted || folder.filename() == "distorted";
  }
  return {model};
}

}  // namespace

PosePlace transforms_place(const fs::path& file) {
  const fs::path folder = file.parent_path();
  return {Kind::transforms, file, {folder, folder / "images"}};
}

std::vector<PosePlace> pose_places(const fs::path& folder) {
  std::vector<PosePlace> places;
  const auto add_model = [&](const fs::path& path, const std::vector<fs::path>& images) {
    if (is_colmap_model(path)) places.push_back({Kind::colmap_model, path, images});
  };
  const auto add_models = [&](const fs::path& path, const std::vector<fs::path>& images) {
    if (has_colmap_models(path)) places.push_back({Kind::colmap_models, path, images});
  };
  const auto images = image_folders(folder, "images", "input");
  const auto photos = image_folders(folder, "input", "images");
  const auto sparse = folder / "sparse", nerfstudio = folder / "colmap" / "sparse",
             distorted = folder / "distorted" / "sparse";
  add_model(sparse, images), add_models(sparse, images);
  add_model(folder, image_folders_above(folder));
  if (has_transforms(folder)) places.push_back(transforms_place(transforms_file(folder)));
  add_models(folder, image_folders_above(folder));
  add_model(nerfstudio, images), add_models(nerfstudio, images);
  add_model(distorted, photos), add_models(distorted, photos);
  return places;
}

bool has_name_of_images(const fs::path& folder) {
  const std::string name = folder.filename().string();
  return name == "images" || name == "input" || name.starts_with("images_");
}

std::vector<PosePlace> pose_places_of_photos(const fs::path& photos) {
  const fs::path above = photos.parent_path();
  const bool others = is_folder(above / "images") || is_folder(above / "input");
  if (others && !has_name_of_images(photos)) return {};
  std::vector<PosePlace> places = pose_places(above);
  // Models in folders beside that of the photos are of other captures
  std::erase_if(places, [&](const PosePlace& place) {
    return place.path == above && place.kind == Kind::colmap_models;
  });
  for (PosePlace& place : places) place.images = {photos};
  return places;
}

}  // namespace fluxgs
