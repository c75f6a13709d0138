// Where a data set keeps its camera poses.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace fluxgs {

struct PosePlace {
  enum class Kind { colmap_model, colmap_models, transforms };
  Kind kind;
  std::filesystem::path path;  ///< a model's folder; a folder of models; the .json file
};

/// The places with poses in a folder, the usual ones first: COLMAP's sparse/ (a model or several),
/// the folder itself as a model, transforms.json, the folder itself with several models,
/// nerfstudio's colmap/sparse/ and the distorted/sparse/ of 3D Gaussian Splatting.
std::vector<PosePlace> pose_places(const std::filesystem::path& folder);

}  // namespace fluxgs
