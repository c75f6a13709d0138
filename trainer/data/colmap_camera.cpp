// COLMAP's camera models (colmap/src/colmap/sensor/models.h documents their parameters).
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "trainer/data/colmap_model.h"

namespace fluxgs {
namespace {

constexpr std::array<ColmapCameraModel, 18> kModels{
    {{0, "SIMPLE_PINHOLE", 3, LensModel::kPerspective},
     {1, "PINHOLE", 4, LensModel::kPerspective},
     {2, "SIMPLE_RADIAL", 4, LensModel::kPerspective},
     {3, "RADIAL", 5, LensModel::kPerspective},
     {4, "OPENCV", 8, LensModel::kPerspective},
     {5, "OPENCV_FISHEYE", 8, LensModel::kFisheye},
     {6, "FULL_OPENCV", 12, LensModel::kPerspective},
     {7, "FOV", 5, LensModel::kFieldOfView},
     {8, "SIMPLE_RADIAL_FISHEYE", 4, LensModel::kFisheye},
     {9, "RADIAL_FISHEYE", 5, LensModel::kFisheye},
     {10, "THIN_PRISM_FISHEYE", 12, LensModel::kThinPrismFisheye},
     {11, "RAD_TAN_THIN_PRISM_FISHEYE", 16, LensModel::kRadTanThinPrismFisheye},
     {12, "SIMPLE_DIVISION", 4, LensModel::kDivision},
     {13, "DIVISION", 5, LensModel::kDivision},
     {14, "SIMPLE_FISHEYE", 3, LensModel::kFisheye},
     {15, "FISHEYE", 4, LensModel::kFisheye},
     {16, "EUCM", 6, LensModel::kEucm},
     {17, "EQUIRECTANGULAR", 2, LensModel::kPerspective}}};

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

  if (model.name == "EQUIRECTANGULAR")
    return fail(
        file, field,
        "camera model EQUIRECTANGULAR: panoramas cannot be trained on, expected images of one "
        "direction each (COLMAP's panorama tools cut them)");
  const bool one_focal = model.name.starts_with("SIMPLE") || model.name.starts_with("RADIAL");
  const std::size_t principal = one_focal ? 1 : 2, rest = principal + 2;
  lens.model = model.lens;
  lens.fx = p[0];
  lens.fy = one_focal ? p[0] : p[1];
  lens.cx = p[principal];
  lens.cy = p[principal + 1];
  std::copy(p.begin() + static_cast<std::ptrdiff_t>(rest), p.end(), lens.distortion.begin());
  if (const auto ok = check_lens(lens, file, field); !ok) return std::unexpected(ok.error());
  return lens;
}

}  // namespace fluxgs
