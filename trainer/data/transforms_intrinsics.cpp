#include "trainer/data/transforms_intrinsics.h"

#include <cmath>
#include <numbers>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/sanitize.h"
#include "trainer/data/source.h"

namespace fluxgs {
namespace {

using Json = nlohmann::json;

/// Read a number into `value` if the key is there; false if it is there and no number.
bool read_number(const Json& json, const char* key, std::optional<double>& value) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  if (!found->is_number()) return false;
  value = found->get<double>();
  return true;
}

/// Two ways to give one focal length: one given here replaces both inherited ones, and the
/// inherited vertical one goes with the inherited horizontal one.
void drop_overridden_focals(const Json& json, TransformsIntrinsics& in) {
  if (json.contains("fl_x") || json.contains("camera_angle_x"))
    in.focal_x = in.angle_x = in.focal_y = in.angle_y = std::nullopt;
  if (json.contains("fl_y") || json.contains("camera_angle_y"))
    in.focal_y = in.angle_y = std::nullopt;
}

Expected<void> parse_model(const Json& json, TransformsIntrinsics& in, const std::string& file,
                           const std::string& field) {
  if (const auto found = json.find("camera_model"); found != json.end()) {
    const std::string name = found->is_string() ? found->get<std::string>() : "";
    const bool perspective = name == "OPENCV" || name == "FULL_OPENCV" || name == "PINHOLE" ||
                             name == "SIMPLE_PINHOLE" || name == "RADIAL" ||
                             name == "SIMPLE_RADIAL";
    if (!perspective && name != "OPENCV_FISHEYE")
      return fail(file, field + "camera_model",
                  fmt::format("\"{}\", expected PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL, "
                              "OPENCV, FULL_OPENCV or OPENCV_FISHEYE",
                              one_line(name)));
    in.model = perspective ? LensModel::kPerspective : LensModel::kFisheye;
  }
  const auto is_true = [&](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && (*found == true || *found == 1);
  };
  if (is_true("is_fisheye")) in.model = LensModel::kFisheye;
  for (const char* key : {"equirectangular", "latlong", "ftheta_p0"})
    if (json.contains(key) && (is_true(key) || json[key].is_number()))
      return fail(file, field + key, "this lens cannot be undistorted, expected OPENCV or PINHOLE");
  return {};
}

/// "k3" is the third radial term of both models, at different places of Lens::distortion.
Expected<void> parse_distortion(const Json& json, TransformsIntrinsics& in, const std::string& file,
                                const std::string& field) {
  constexpr std::array kPerspective{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  constexpr std::array kFisheye{"k1", "k2", "k3", "k4"};
  const auto read = [&](const auto& keys) -> Expected<void> {
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (!read_number(json, keys[i], in.distortion[i]))
        return fail(file, field + keys[i], "expected a number");
    return {};
  };
  return in.model == LensModel::kFisheye ? read(kFisheye) : read(kPerspective);
}

constexpr double kLargestSide = 1e5;  // pixels; what a w or h may claim

/// Half the image over the tangent of half the angle; not positive for angles outside 0…180°.
double focal_from_angle(double size, double angle) {
  const bool possible = angle > 0 && angle < std::numbers::pi;
  return possible ? 0.5 * size / std::tan(0.5 * angle) : 0.0;
}

}  // namespace

Expected<TransformsIntrinsics> parse_intrinsics(const Json& json,
                                                const TransformsIntrinsics& inherited,
                                                const std::string& file, const std::string& field) {
  TransformsIntrinsics in = inherited;
  drop_overridden_focals(json, in);
  const std::pair<const char*, std::optional<double>*> numbers[] = {
      {"w", &in.width},
      {"h", &in.height},
      {"fl_x", &in.focal_x},
      {"fl_y", &in.focal_y},
      {"cx", &in.center_x},
      {"cy", &in.center_y},
      {"camera_angle_x", &in.angle_x},
      {"camera_angle_y", &in.angle_y}};
  for (const auto& [key, value] : numbers)
    if (!read_number(json, key, *value)) return fail(file, field + key, "expected a number");
  if (const auto ok = parse_model(json, in, file, field); !ok) return std::unexpected(ok.error());
  if (const auto ok = parse_distortion(json, in, file, field); !ok)
    return std::unexpected(ok.error());
  return in;
}

Expected<Lens> make_lens(const TransformsIntrinsics& in, ImageSize image, const std::string& file,
                         const std::string& field) {
  const double width = in.width.value_or(image.width), height = in.height.value_or(image.height);
  if (!(width >= 1) || !(height >= 1) || !std::isfinite(width) || !std::isfinite(height))
    return fail(file, field + "w, h",
                fmt::format("image size {:g}x{:g}, expected positive numbers", width, height));
  if (!in.focal_x && !in.angle_x && !in.focal_y && !in.angle_y)
    return fail(file, field + "fl_x", "missing, expected fl_x or camera_angle_x");

  for (const auto& [key, angle, focal] : {std::tuple("camera_angle_x", in.angle_x, in.focal_x),
                                          std::tuple("camera_angle_y", in.angle_y, in.focal_y)})
    if (angle && !focal && !(*angle > 0 && *angle < std::numbers::pi))
      return fail(file, field + key,
                  fmt::format("{:g}, expected radians, between 0 and pi{}", *angle,
                              *angle > 5 && *angle < 180 ? "; is this degrees?" : ""));
  std::optional<double> fx = in.focal_x, fy = in.focal_y;
  if (!fx && in.angle_x) fx = focal_from_angle(width, *in.angle_x);
  if (!fy && in.angle_y) fy = focal_from_angle(height, *in.angle_y);
  if (width > kLargestSide || height > kLargestSide)
    return fail(
        file, field + "w, h",
        fmt::format("image size {:g}x{:g}, expected at most {:g}", width, height, kLargestSide));
  Lens lens{.model = in.model,
            .width = static_cast<int>(std::lround(width)),
            .height = static_cast<int>(std::lround(height)),
            .fx = fx ? *fx : *fy,
            .fy = fy ? *fy : *fx,
            .cx = in.center_x.value_or(width / 2),
            .cy = in.center_y.value_or(height / 2)};
  for (std::size_t i = 0; i < in.distortion.size(); ++i)
    lens.distortion[i] = in.distortion[i].value_or(0);
  if (const auto ok = check_lens(lens, file, field + "intrinsics"); !ok)
    return std::unexpected(ok.error());
  return lens;
}

}  // namespace fluxgs
