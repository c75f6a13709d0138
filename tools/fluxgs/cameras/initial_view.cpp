#include "tools/fluxgs/cameras/initial_view.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "camera/initial_view.h"
#include "camera/up_axis.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs::cli {
// From the edge of a capture, half of the ways to turn lead to where nothing was seen.
const View& middle_of(const std::vector<View>& views) {
  const auto distances = [&](const View& view) {
    double sum = 0;
    for (const View& other : views)
      sum += glm::distance(view.camera.center(), other.camera.center());
    return sum;
  };
  const View* best = &views.front();
  double least = distances(*best);
  for (const View& view : views) {
    const double sum = distances(view);
    if (sum < 0.999 * least) best = &view, least = sum;  // around in a circle: the first
  }
  return *best;
}

namespace {

struct NamedUp {
  glm::dvec3 direction;
  std::string source;
};

NamedUp choose_up(const SplatCloud& cloud, const std::optional<InitialView>& start,
                  const std::optional<Dataset>& data, const std::optional<glm::dvec3>& given) {
  if (given) return {*given, "as given"};
  if (data) {
    const camera::UpAxis up = camera::up_of_cameras(cameras_of(data->train));
    return {up.direction, fmt::format("from the images, confidence {:.2f}", up.confidence)};
  }
  if (start) return {start->up, "from the scene"};
  const camera::UpAxis up = camera::up_of_cloud(cloud);
  if (up.confidence > 0)
    return {up.direction, fmt::format("from the splats, confidence {:.2f}", up.confidence)};
  return {up.direction, "the default; the splats do not tell"};
}

/// The view of a camera, with the target at the depth of the scene's middle.
camera::ViewState view_into(const camera::SceneBounds& bounds, const Camera& camera) {
  const double depth = glm::dot(bounds.center - camera.center(), camera.forward());
  return camera::view_of(camera, std::max(depth, 0.1 * bounds.radius));
}

}  // namespace

InitialView initial_view_of(const std::vector<View>& views) {
  const Camera& middle = middle_of(views).camera;
  const camera::ViewState view = camera::view_of(middle, 1);
  return {.position = camera::eye(view),
          .orientation = view.orientation,
          .fov_y = view.fov,
          .up = camera::up_of_cameras(cameras_of(views)).direction,
          .image_width = middle.width,
          .image_height = middle.height};
}

Expected<std::optional<glm::dvec3>> parse_up(const std::string& text) {
  if (text == "auto") return std::nullopt;
  glm::dvec3 up(0);
  const char* at = text.data();
  const char* const end = at + text.size();
  bool good = true;
  for (int i = 0; i < 3 && good; ++i) {
    const auto [rest, error] = std::from_chars(at, end, up[i]);
    good = error == std::errc() && (i == 2 ? rest == end : rest != end && *rest == ',');
    at = rest + (i < 2 ? 1 : 0);
  }
  const double length = glm::length(up);
  if (!good || !(length > 1e-9 && length < 1e9))
    return fail("", "", fmt::format("'{}' is not a direction, expected x,y,z or auto", text));
  return up / length;
}

InitialNavigation initial_navigation(const SplatCloud& cloud,
                                     const std::optional<InitialView>& start,
                                     const std::optional<Dataset>& data,
                                     const std::optional<Camera>& camera,
                                     const std::optional<glm::dvec3>& up, const ImageSize& size) {
  const camera::SceneBounds bounds = camera::robust_bounds(cloud);
  const NamedUp chosen = choose_up(cloud, start, data, up);
  camera::ViewState view;
  if (camera) {
    view = view_into(bounds, *camera);
  } else if (data) {
    view = camera::view_of(data->train[0].camera, focus_distances(data->train)[0]);
  } else if (start) {
    view = camera::initial_navigation(cloud, start, {size.width, size.height}).view;
  } else {
    view = camera::fitting_view(bounds, chosen.direction, camera::kDefaultFieldOfView);
  }
  return {camera::navigation_from(view, chosen.direction, camera::units_of(bounds)), chosen.source};
}

}  // namespace fluxgs::cli
