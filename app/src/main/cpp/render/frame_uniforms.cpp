#include "render/frame_uniforms.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "fluxgs/math/projection.h"
#include "gl/expected_chain.h"

namespace fluxgs::render {
namespace {

std::array<float, 4> pack(const math::Vec3<double>& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0.0F};
}

std::array<float, 4> pack(double a, double b, double c, double d) {
  return {static_cast<float>(a), static_cast<float>(b), static_cast<float>(c),
          static_cast<float>(d)};
}

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Expected<void> check_camera(const Camera& c) {
  const std::string file = c.name.empty() ? "camera" : "camera " + c.name;
  if (c.width < 1 || c.height < 1) {
    return fail(file, "size",
                std::to_string(c.width) + "×" + std::to_string(c.height) +
                    " pixels; at least 1×1 is needed");
  }
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  if (!positive(c.fx) || !positive(c.fy)) {
    return fail(file, "focal length", "must be positive and finite");
  }
  if (!std::isfinite(c.cx) || !std::isfinite(c.cy)) {
    return fail(file, "principal point", "must be finite");
  }
  const bool pose = finite(c.rotation[0]) && finite(c.rotation[1]) && finite(c.rotation[2]) &&
                    finite(c.translation);
  if (!pose) return fail(file, "pose", "must be finite");
  return {};
}

Expected<void> check_options(const RenderOptions& o) {
  const auto fraction = [](double v) { return v > 0 && v <= 1; };
  if (!fraction(o.alpha_min)) return fail("options", "alpha_min", "must lie in (0, 1]");
  if (!fraction(o.alpha_max)) return fail("options", "alpha_max", "must lie in (0, 1]");
  if (!(o.dilation > 0) || !std::isfinite(o.dilation)) {
    return fail("options", "dilation", "must be positive and finite");
  }
  if (!(o.near_plane > 0) || !std::isfinite(o.near_plane)) {
    return fail("options", "near_plane", "must be positive and finite");
  }
  if (!(o.depth_spread_max >= 0) || !std::isfinite(o.depth_spread_max)) {
    return fail("options", "depth_spread_max", "must be finite and not negative");
  }
  if (!(o.frustum_margin >= 0) || !std::isfinite(o.frustum_margin)) {
    return fail("options", "frustum_margin", "must be finite and not negative");
  }
  if (o.sh_degree < 0 || o.sh_degree > 3) return fail("options", "sh_degree", "must be 0…3");
  const auto color = [](double v) { return v >= 0 && v <= 1; };
  if (!color(o.background.r) || !color(o.background.g) || !color(o.background.b)) {
    return fail("options", "background", "must lie in 0…1");
  }
  return {};
}

}  // namespace

Expected<void> check_view(const Camera& camera, const RenderOptions& options) {
  return gl::chain([&] { return check_camera(camera); }, [&] { return check_options(options); });
}

sort::DepthKeys choose_keys(const Camera& camera, const RenderOptions& options,
                            const SceneConstants& scene, int key_bits) {
  const glm::dvec3 centre = camera.center() - scene.origin;
  const glm::dvec3 forward = camera.forward();
  double nearest = 0, farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = forward[axis] * (scene.lowest[axis] - centre[axis]);
    const double b = forward[axis] * (scene.highest[axis] - centre[axis]);
    nearest += std::min(a, b);
    farthest += std::max(a, b);
  }
  // A little more than the box, for the rounding of the GPU's depths
  constexpr double kSlack = 1e-4, kLargest = 1e30;
  const double low = std::clamp(nearest * (1 - kSlack), options.near_plane, kLargest);
  const double high = std::clamp(farthest * (1 + kSlack), low, kLargest);
  return sort::depth_keys(static_cast<float>(low), static_cast<float>(high), key_bits);
}

namespace {

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
  const auto view = math::make_view<double>(camera, options);
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
  u.size_min = static_cast<float>(approximation.min_size);
  u.sort_margin = static_cast<float>(sort_margin(camera, approximation.resort_motion));
  u.key_low = keys.low;
  u.key_shift = keys.shift;
  u.key_max = keys.largest;
  return u;
}

}  // namespace fluxgs::render
