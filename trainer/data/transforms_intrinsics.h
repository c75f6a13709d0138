// The intrinsics of transforms.json: global ones, overridden frame by frame.
#pragma once

#include <array>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "fluxgs/error.h"
#include "trainer/data/image_io.h"
#include "trainer/data/lens.h"

namespace fluxgs {

struct TransformsIntrinsics {
  LensModel model = LensModel::kPerspective;
  std::optional<double> width, height;       ///< of the images that the numbers below are for
  std::optional<double> focal_x, focal_y;    ///< pixels
  std::optional<double> angle_x, angle_y;    ///< radians, the whole field of view
  std::optional<double> center_x, center_y;  ///< pixels
  std::array<std::optional<double>, 8> distortion;  ///< in the order of Lens::distortion
};

/// The intrinsics of a frame, or of the whole file: what `json` says, and `inherited` where it says
/// nothing. Errors: values that are not numbers, camera models that cannot be undistorted.
Expected<TransformsIntrinsics> parse_intrinsics(const nlohmann::json& json,
                                                const TransformsIntrinsics& inherited,
                                                const std::string& file, const std::string& field);

/// The lens in the resolution that the intrinsics are given for: that of the image if they do not
/// say. Without a principal point the image's centre is taken, without a vertical focal length
/// pixels are square. Errors: no focal length at all, intrinsics that no camera has.
Expected<Lens> make_lens(const TransformsIntrinsics& intrinsics, ImageSize image,
                         const std::string& file, const std::string& field);

}  // namespace fluxgs
