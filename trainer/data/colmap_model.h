// A COLMAP sparse model as its files store it, binary or text
// (https://colmap.github.io/format.html).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "trainer/data/lens.h"

namespace fluxgs {

struct ColmapObservation {
  glm::dvec2 pixel{0.0};
  std::int64_t point_id = -1;  ///< −1: none
};

struct ColmapImage {
  std::string name;  ///< relative to the folder of images
  std::uint32_t camera_id = 0;
  glm::dquat rotation{1, 0, 0, 0};  ///< world → camera, as stored: not normalised, not checked
  glm::dvec3 translation{0.0};
  std::vector<ColmapObservation> observations;
};

struct ColmapPoint {
  std::uint64_t id = 0;
  glm::dvec3 position{0.0};
  glm::u8vec3 color{0};
};

struct ColmapModel {
  /// A camera that no image can have is an error, for the images that use it.
  std::map<std::uint32_t, Expected<Lens>> cameras;
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint> points;
  bool has_points_file = false;  ///< points3D may be missing; cameras and images may not
  std::vector<std::string> warnings;
};

/// True if a folder holds cameras.bin or cameras.txt.
bool is_colmap_model(const std::filesystem::path& folder);

/// A model by its folder, and the number of images that it says it has.
struct ColmapModelFolder {
  std::filesystem::path folder;
  std::uint64_t images = 0;  ///< counted only where there are several models
};

/// True if a folder has a model in a sub-folder.
bool has_colmap_models(const std::filesystem::path& sparse);

/// The models in the sub-folders of a folder, those with most images first: COLMAP makes several
/// where the images do not hang together.
std::vector<ColmapModelFolder> colmap_models(const std::filesystem::path& sparse);

/// True if the binary files of a model are read: cameras.bin exists, and images.bin or no text
/// model beside it.
bool is_binary_model(const std::filesystem::path& folder);

/// Read a model, by its binary files or its text files.
/// Counts are checked against what is left of the file before anything is allocated, and a file
/// must end where its last record does. Values are left as they are: NaN poses, unknown camera ids
/// and the like are the caller's to refuse.
Expected<ColmapModel> read_colmap_model(const std::filesystem::path& folder);

Expected<ColmapModel> read_colmap_binary(const std::filesystem::path& folder);
Expected<ColmapModel> read_colmap_text(const std::filesystem::path& folder);

/// COLMAP's camera models by number in binary files and by name in text files.
struct ColmapCameraModel {
  int id;
  std::string_view name;
  int parameters;
  LensModel lens;
};
/// Nothing if there is no such model.
const ColmapCameraModel* find_camera_model(int id);
const ColmapCameraModel* find_camera_model(std::string_view name);

/// The lens that a model and its parameters describe. Errors: models that cannot be undistorted
/// here, named with those that can; intrinsics that no camera has.
Expected<Lens> make_colmap_lens(const ColmapCameraModel& model, std::uint64_t width,
                                std::uint64_t height, const std::vector<double>& parameters,
                                const std::string& file, const std::string& field);

}  // namespace fluxgs
