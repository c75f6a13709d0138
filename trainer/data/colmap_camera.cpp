// COLMAP's camera models (colmap/src/colmap/sensor/models.h documents their parameters).
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "trainer/data/colmap_model.h"

namespace fluxgs {
namespace {

constexpr std::array<ColmapCameraModel, 12> kModels{{{0, "SIMPLE_PINHOLE", 3},
                                                     {1, "PINHOLE", 4},
                                                     {2, "SIMPLE_RADIAL", 4},
                                                     {3, "RADIAL", 5},
                                                     {4, "OPENCV", 8},
                                                     {5, "OPENCV_FISHEYE", 8},
                                                     {6, "FULL_OPENCV", 12},
                                                     {7, "FOV", 5},
                                                     {8, "SIMPLE_RADIAL_FISHEYE", 4},
                                                     {9, "RADIAL_FISHEYE", 5},
                                                     {10, "THIN_PRISM_FISHEYE", 12},
                                                     {11, "RAD_TAN_THIN_PRISM_FISHEYE", 16}}};

constexpr std::string_view kAccepted =
    "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE, "
    "SIMPLE_RADIAL_FISHEYE or RADIAL_FISHEYE";

}  // namespace

const ColmapCameraModel* find_camera_model(int id) {
  const auto found = std::ranges::find(kModels, id, &ColmapCameraModel::id);
  return found == kModels.end() ? nullptr : &*found;
}

const ColmapCameraModel* find_camera_model(std::string_view name) {
  const auto found = std::ranges::find(kModels, name, &ColmapCameraModel::name);
  return found == kModels.end() ? nullptr : &*found;
}

Expected<Lens> make_colmap_lens(const ColmapCameraModel& model, std::uint64_t width,
                                std::uint64_t height, const std::vector<double>& p,
                                const std::string& file, const std::string& field) {
  constexpr std::uint64_t kLongest = kMaxPixels;
  Lens lens;
  lens.width = static_cast<int>(std::min(width, kLongest + 1));
  lens.height = static_cast<int>(std::min(height, kLongest + 1));

  const bool one_focal = model.name.starts_with("SIMPLE") || model.name.starts_with("RADIAL");
  const std::size_t principal = one_focal ? 1 : 2, rest = principal + 2;
  lens.fx = p[0];
  lens.fy = one_focal ? p[0] : p[1];
  lens.cx = p[principal];
  lens.cy = p[principal + 1];
  if (model.name.ends_with("FISHEYE")) lens.model = LensModel::kFisheye;

  // The remaining parameters are in OpenCV's order for every model that is accepted.
  if (model.name == "FOV" || model.id >= 10)
    return fail(file, field,
                fmt::format("camera model {}, expected {} (undistort the images with COLMAP)",
                            model.name, kAccepted));
  std::copy(p.begin() + static_cast<std::ptrdiff_t>(rest), p.end(), lens.distortion.begin());
  if (const auto ok = check_lens(lens, file, field); !ok) return std::unexpected(ok.error());
  return lens;
}

}  // namespace fluxgs
