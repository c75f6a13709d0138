// Posed images, ready to train on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/image.h"
#include "trainer/core/progress.h"

namespace fluxgs {

/// Meaning of what masks leave black and of what photos leave transparent.
enum class MaskUse {
  automatic,  ///< ignore for masks, carve for transparency
  ignore,     ///< says nothing: neither loss nor score
  carve,      ///< must stay empty
  off,        ///< masks are not read; transparent pixels show the background
};
inline constexpr std::array<std::string_view, 4> kMaskUseNames = {"auto", "ignore", "carve", "off"};

struct LoadOptions {
  /// Integer factor ≥ 1, area-averaged, sizes rounded down; 0: the longer side is limited to
  /// kDefaultLongestSide (reduction.h).
  int downscale = 1;
  /// Pixels of the longer side that a scene was trained with: where `downscale` is 0, images are
  /// reduced by the whole factor that comes nearest to it. 0: not known.
  int trained_side = 0;
  /// Every n-th image, sorted by name, is for testing; 0: none. Without a value as the data set
  /// says, or every eighth (holdout.h).
  std::optional<int> test_every = {};
  std::filesystem::path test_list = {};  ///< names of the images for testing, one a line, or JSON
  glm::vec3 background{0};               ///< sRGB as stored, 0…1: what transparent pixels show
  int threads = 0;                       ///< for decoding; 0: all
  MaskUse masks = MaskUse::automatic;
  ProgressReport progress = {};  ///< images ready
  int video_frames = 0;          ///< taken of a video; 0: as before, or kDefaultVideoFrames
  StepReport steps = {};         ///< of finding poses
  /// Bytes of memory that pixels may take; more of them lie in files. 0: half of what is free.
  std::uint64_t max_photo_bytes = 0;
};

/// An image as an ideal pinhole camera would have taken it: distortion undone, reduced by
/// LoadOptions::downscale, opaque. The camera's intrinsics are those of these pixels.
struct View {
  Camera camera;  ///< its name is the image's file name (COLMAP: the name in the model)
  Image<std::uint8_t> rgb;
  std::string path;  ///< of the file the pixels came from
  /// 255 where a pixel counts, 0 where it is ignored; 1 channel, the size of rgb. Empty: all count.
  Image<std::uint8_t> used = {};
  /// 255·α: what is transparent must stay empty; 1 channel, the size of rgb. Empty: opaque.
  Image<std::uint8_t> alpha = {};
  glm::vec3 background{0};  ///< that rgb shows behind alpha
};

/// A pixel of a reduced mask counts if this much of it is white (of 255): less would let in the
/// colour of what is masked.
inline constexpr int kCounts = 230;

/// World coordinates are those of the data set, untouched: of transforms.json only the camera axes
/// are converted (from OpenGL's to OpenCV's).
struct Dataset {
  std::string kind;  ///< "COLMAP", "transforms.json", "images (COLMAP)" or "video (COLMAP)"
  std::vector<View> train, test;          ///< each sorted by name; train is never empty
  std::vector<glm::vec3> points;          ///< sparse points, finite; may be empty
  std::vector<glm::u8vec3> point_colors;  ///< sRGB, one per point
  std::filesystem::path points_file;      ///< the .ply that they came from, if it was one
  std::size_t skipped_images = 0;         ///< listed, but without an image file
  std::vector<std::string> warnings;      ///< one line each, for the user
};

/// True if no pixel counts, or all are transparent.
bool is_masked_whole(const View& view);

std::vector<Camera> cameras_of(const std::vector<View>& views);

/// At most `count` of `all` indices, evenly spread, rising. `turn`, 0…1, chooses among those that
/// lie between two of them: ½ is the middle.
std::vector<std::uint32_t> spread_indices(std::size_t all, std::size_t count, double turn = 0.5);

/// At most `count` of the cameras, evenly spread over them.
std::vector<Camera> spread_cameras(const std::vector<Camera>& cameras, std::size_t count);

/// Load a folder, the first of these that it holds:
///   - a COLMAP model (binary or text) in sparse/0, sparse or the folder itself, its images in
///     images/ or the folder itself;
///   - transforms_train.json, with transforms_test.json as the test split if it exists;
///   - transforms.json (instant-ngp, nerfstudio);
///   - a COLMAP model in colmap/sparse (nerfstudio);
///   - images without poses, or a video, which may also be named itself: COLMAP finds the poses, if
///     installed (photos/photos_source.h).
/// Masks are those that transforms.json names (mask_path), and the images of a folder masks/ or
/// mask/ that have the photos' names (see find_masks.h). Photos that a mask leaves nothing of are
/// left out. The result does not depend on the number of threads. Errors: anything missing,
/// malformed, truncated or contradictory, named by file and field.
Expected<Dataset> load_dataset(const std::filesystem::path& folder, const LoadOptions& options);

}  // namespace fluxgs
