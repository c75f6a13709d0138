// The places of camera poses in a data set, and of their images.
#pragma once

#include <filesystem>
#include <vector>

namespace fluxgs {

struct PosePlace {
  enum class Kind { colmap_model, colmap_models, transforms };
  Kind kind;
  std::filesystem::path path;  ///< a model's folder; a folder of models; the .json file
  /// The folders that names of images are relative to, the likeliest first.
  std::vector<std::filesystem::path> images;
};

/// The places with poses in a folder, the usual ones first: COLMAP's sparse/ (a model or several),
/// the folder itself as a model, transforms.json, the folder itself with several models,
/// nerfstudio's colmap/sparse/ and the distorted/sparse/ of 3D Gaussian Splatting.
std::vector<PosePlace> pose_places(const std::filesystem::path& folder);

/// A transforms.json (by any name) that is itself given as the data set.
PosePlace transforms_place(const std::filesystem::path& file);

/// Those of the folder above one of photos that may belong to them: its name is usual for the
/// images of a data set, or the folder above has no such images. `images` is the folder of photos.
std::vector<PosePlace> pose_places_of_photos(const std::filesystem::path& photos);

/// True for images, input, and reduced copies such as images_4.
bool has_name_of_images(const std::filesystem::path& folder);

}  // namespace fluxgs
