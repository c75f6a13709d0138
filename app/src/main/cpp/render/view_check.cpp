#include "render/view_check.h"

#include <cmath>
#include <string>

#include "gl/expected_chain.h"

namespace fluxgs::render {
namespace {

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::string name_of(const Camera& c) { return c.name.empty() ? "camera" : "camera " + c.name; }

Expected<void> check_camera(const Camera& c) {
  if (auto size = check_image_size(c); !size) return size;
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  if (!positive(c.fx) || !positive(c.fy)) {
    return fail(name_of(c), "focal length", "must be positive and finite");
  }
  if (!std::isfinite(c.cx) || !std::isfinite(c.cy)) {
    return fail(name_of(c), "principal point", "must be finite");
  }
  const bool pose = finite(c.rotation[0]) && finite(c.rotation[1]) && finite(c.rotation[2]) &&
                    finite(c.translation);
  if (!pose) return fail(name_of(c), "pose", "must be finite");
  return {};
}

Expected<void> check_options(const RenderOptions& o) {
  const auto fraction = [](double v) { return v > 0 && v <= 1; };
  if (!fraction(o.alpha_min)) return fail("options", "alpha_min", "must lie in (0, 1]");
  if (!fraction(o.alpha_max)) return fail("options", "alpha_max", "must lie in (0, 1]");
  if (o.filter && (!(o.filter->dilation > 0) || !std::isfinite(o.filter->dilation))) {
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

Expected<void> check_image_size(const Camera& camera) {
  if (camera.width >= 1 && camera.height >= 1) return {};
  return fail(name_of(camera), "size",
              std::to_string(camera.width) + "×" + std::to_string(camera.height) +
                  " pixels; at least 1×1 is needed");
}

Expected<void> check_view(const Camera& camera, const RenderOptions& options) {
  return gl::chain([&] { return check_camera(camera); }, [&] { return check_options(options); });
}

}  // namespace fluxgs::render
