#include "render/frame_uniforms.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "fluxgs/math/projection.h"
#include "gl/steps.h"

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
  if (!(o.frustum_margin >= 0) || !std::isfinite(o.frustum_margin)) {
    return fail("options", "frustum_margin", "must be finite and not negative");
  }
  if (o.sh_degree < 0 || o.sh_degree > 3) return fail("options", "sh_degree", "must be 0…3");
  if (!finite(o.background)) return fail("options", "background", "must be finite");
  return {};
}

}  // namespace

Expected<void> check_view(const Camera& camera, const RenderOptions& options) {
  return gl::in_turn([&] { return check_camera(camera); }, [&] { return check_options(options); });
}

FrameUniforms make_frame_uniforms(const Camera& camera, const RenderOptions& options,
                                  const glm::dvec3& origin, std::uint32_t splat_count,
                                  int sh_degree) {
  const auto view = math::make_view<double>(camera, options);
  const glm::dvec3 centre = camera.center() - origin;
  FrameUniforms u{};
  u.rotation_row0 = pack(view.rotation.row0);
  u.rotation_row1 = pack(view.rotation.row1);
  u.rotation_row2 = pack(view.rotation.row2);
  u.camera_centre = pack({centre.x, centre.y, centre.z});
  u.focal_centre = pack(view.fx, view.fy, view.cx, view.cy);
  u.slope_limits = pack(view.slope_x_min, view.slope_x_max, view.slope_y_min, view.slope_y_max);
  u.target_size = {static_cast<float>(view.width), static_cast<float>(view.height)};
  u.alpha_min = static_cast<float>(options.alpha_min);
  u.alpha_max = static_cast<float>(options.alpha_max);
  u.dilation = static_cast<float>(view.dilation);
  u.near_plane = static_cast<float>(view.near_plane);
  u.splat_count = splat_count;
  u.sh_degree = static_cast<std::uint32_t>(std::min(options.sh_degree, sh_degree));
  return u;
}

}  // namespace fluxgs::render
