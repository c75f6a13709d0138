#include "tools/fluxgs/commands/scene_map.h"

#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

#include "tools/fluxgs/options/data_options.h"

namespace fluxgs::cli {
namespace {

constexpr glm::dvec3 kUp(0, -1, 0);  // of scenes as 3DGS has them, and of viewers
constexpr double kMaxLength = 1e12;

/// "1,-2,0.5", each within ± kMaxLength.
std::optional<glm::dvec3> vector_of(const std::string& text) {
  glm::dvec3 v;
  const char *at = text.data(), *end = at + text.size();
  for (int c = 0; c < 3; ++c) {
    const auto [rest, failed] = std::from_chars(at, end, v[c]);
    if (failed != std::errc() || !(std::abs(v[c]) <= kMaxLength)) return std::nullopt;
    if (c < 2 ? rest == end || *rest != ',' : rest != end) return std::nullopt;
    at = rest + 1;
  }
  return v;
}

/// A direction of unit length, from the name of an axis or a vector.
std::optional<glm::dvec3> direction_of(const std::string& text) {
  const std::size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
  if (text.size() == sign + 1 && text[sign] >= 'x' && text[sign] <= 'z') {
    glm::dvec3 axis(0);
    axis[text[sign] - 'x'] = text[0] == '-' ? -1 : 1;
    return axis;
  }
  const auto v = vector_of(text);
  if (!v || !(glm::length(*v) > 1e-9)) return std::nullopt;
  return glm::normalize(*v);
}

/// The shortest turn; the opposite direction goes round the axis of view, z.
glm::dquat turn_to_up(const glm::dvec3& from) {
  const double cosine = glm::dot(from, kUp);
  if (cosine < -1 + 1e-12) return glm::dquat(0, 0, 0, 1);
  return glm::normalize(glm::dquat(1 + cosine, glm::cross(from, kUp)));
}

glm::dquat rotation_of(const MapOptions& options) {
  glm::dquat rotation(1, 0, 0, 0);
  if (options.turns_up()) rotation = turn_to_up(*direction_of(options.up));
  for (int c = 0; c < 3; ++c) {
    glm::dvec3 axis(0);
    axis[c] = 1;
    rotation = glm::angleAxis(glm::radians(options.rotate[c]), axis) * rotation;
  }
  return glm::normalize(rotation);
}

void add_vector(CLI::App& command, const std::string& name, glm::dvec3& to,
                const std::string& help) {
  command
      .add_option_function<std::string>(
          name, [&to](const std::string& text) { to = *vector_of(text); }, help)
      ->check([](const std::string& text) {
        return vector_of(text) ? ""
                               : fmt::format("expected three numbers, x,y,z, up to {:g}, not {}",
                                             kMaxLength, text);
      })
      ->type_name("X,Y,Z");
}

}  // namespace

void add_map_options(CLI::App& command, MapOptions& options) {
  const std::string group = "Turn, resize, move; axes as `info` shows them, y down";
  command.add_option("--up", options.up, "direction that becomes up: x, -x, y, -y, z, -z or X,Y,Z")
      ->check([](const std::string& text) {
        return direction_of(text) ? "" : "expected an axis such as -z, or x,y,z, not " + text;
      })
      ->type_name("AXIS")
      ->group(group);
  add_vector(command, "--rotate", options.rotate,
             "degrees about the axes x, y and z, one after the other");
  command.add_option("--scale", options.scale, "factor of all lengths")
      ->check(in_range(1e-6, 1e6))
      ->capture_default_str();
  add_vector(command, "--translate", options.translate, "scene units, after the others");
  for (const char* name : {"--rotate", "--scale", "--translate"})
    command.get_option(name)->group(group);
}

AffineMap map_of(const MapOptions& options) {
  const glm::dquat rotation = rotation_of(options);
  // No rounding where nothing turns
  const bool turns = std::abs(rotation.w) < 1;
  return {options.scale * (turns ? glm::mat3_cast(rotation) : glm::dmat3(1.0)), options.translate};
}

void map_scene(const MapOptions& options, SceneFile& scene) {
  const AffineMap map = map_of(options);
  if (map == AffineMap{}) return;
  transform_splats(map, scene.cloud, 0, scene.cloud.size());
  scene.dropped += drop_non_finite(scene.cloud);
  if (!scene.start) return;
  const glm::dquat rotation = rotation_of(options);
  InitialView& view = *scene.start;
  view.position = map.linear * view.position + map.translation;
  view.orientation = glm::normalize(rotation * view.orientation);
  view.up = glm::normalize(rotation * view.up);
  if (options.turns_up()) {  // whatever the file held for up
    MapOptions behind = options;
    behind.up.clear();
    view.up = glm::normalize(rotation_of(behind) * kUp);
  }
}

}  // namespace fluxgs::cli
