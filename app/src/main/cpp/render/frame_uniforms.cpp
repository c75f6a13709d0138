#include "render/frame_uniforms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fluxgs/math/projection.h"

namespace fluxgs::render {
namespace {

std::array<float, 4> pack(const math::Vec3<double>& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0.0F};
}

std::array<float, 4> pack(double a, double b, double c, double d) {
  return {static_cast<float>(a), static_cast<float>(b), static_cast<float>(c),
          static_cast<float>(d)};
}

// px: how far the image's border can move before the splats are sorted again. A turn moves it by
// the focal length times the angle at the centre, and by more at an angle to it.
double sort_margin(const Camera& camera, double motion) {
  if (motion == 0) return 0;
  const double reach = std::max(std::max(camera.cx, camera.width - camera.cx) / camera.fx,
                                std::max(camera.cy, camera.height - camera.cy) / camera.fy);
  return 2 * motion * std::max(camera.fx, camera.fy) * (1 + reach * reach);
}

}  // namespace

double radius_limit(double max_deviations) {
  constexpr double kNone = 1e3;  // No opacity reaches so far
  return (max_deviations > 0 ? max_deviations : kNone) * std::sqrt(0.5 * std::numbers::log2e);
}

FrameUniforms make_frame_uniforms(const Camera& camera, const RenderOptions& options,
                                  const ApproximationSettings& approximation,
                                  const SceneConstants& scene, const sort::DepthKeys& keys) {
  const auto view = math::make_view<double>(camera, for_scene(options, scene.filter));
  const glm::dvec3 centre = camera.center() - scene.origin;
  FrameUniforms u{};
  u.rotation_row0 = pack(view.rotation.row0);
  u.rotation_row1 = pack(view.rotation.row1);
  u.rotation_row2 = pack(view.rotation.row2);
  u.camera_centre = pack({centre.x, centre.y, centre.z});
  u.focal_centre = pack(view.fx, view.fy, view.cx, view.cy);
  u.slope_limits = pack(view.slope_x_min, view.slope_x_max, view.slope_y_min, view.slope_y_max);
  u.target_size = {static_cast<float>(view.width), static_cast<float>(view.height)};
  u.level_min = static_cast<float>(std::log2(options.alpha_min));
  u.alpha_max = static_cast<float>(options.alpha_max);
  u.dilation = static_cast<float>(view.dilation);
  u.near_plane = static_cast<float>(view.near_plane);
  u.depth_spread_max = static_cast<float>(view.depth_spread_max);
  u.splat_count = scene.count;
  u.sh_degree = static_cast<std::uint32_t>(std::min(options.sh_degree, scene.sh_degree));
  u.radius_max = static_cast<float>(radius_limit(approximation.max_deviations));
  u.weight_min = static_cast<float>(approximation.min_weight / (2 * std::numbers::pi));
  u.sort_margin = static_cast<float>(sort_margin(camera, approximation.resort_motion));
  u.key_low = keys.low;
  u.key_shift = keys.shift;
  u.key_max = keys.largest;
  return u;
}

}  // namespace fluxgs::render
