// A data set as its readers return it: images with poses and lenses.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "trainer/data/lens.h"

namespace fluxgs {

struct SourceFrame {
  std::filesystem::path file;
  std::string name;
  std::filesystem::path mask = {};  ///< empty: none
  Lens lens;
  int orientation = 1;          ///< EXIF's: how the stored image is turned when it is loaded
  glm::dmat3 rotation{1.0};     ///< world → camera, OpenCV axes
  glm::dvec3 translation{0.0};  ///< as in Camera
};

/// Position of a frame's camera in the world.
glm::dvec3 camera_position(const SourceFrame& frame);

/// Names of images by split, as a file of the data set lists them.
struct SplitLists {
  std::vector<std::string> train, test;
  std::string file;  ///< empty: there are no lists
};

struct Source {
  std::vector<SourceFrame> frames;
  bool has_split = false;  ///< the data set says itself which frames are for testing
  std::vector<SourceFrame> test_frames;
  SplitLists split;                ///< names inside of the data set's own file
  std::vector<glm::dvec3> points;  ///< finite, also as float
  std::vector<glm::u8vec3> point_colors;
  std::filesystem::path points_file;  ///< the .ply that the points came from, if it was one
  std::size_t skipped_images = 0;
  std::vector<std::string> warnings;
};

/// Those of all frames, the training ones first.
std::vector<glm::dvec3> camera_positions(const Source& source);

/// Add a point unless it is not finite; returns whether it was added.
bool add_point(Source& source, const glm::dvec3& position, const glm::u8vec3& color);

/// Adds the vertices of a .ply to the points, and a warning where some are not finite. Errors:
/// those of read_file() and read_ply_points().
Expected<void> add_ply_points(const std::filesystem::path& file, Source& source);

/// The closest rotation to a matrix that is one but for rounding and a uniform scale (some
/// exporters scale their poses). Nothing if it is not finite, mirrors, or shears by more
/// than 1%.
std::optional<glm::dmat3> nearest_rotation(const glm::dmat3& matrix);

}  // namespace fluxgs
