#include "tools/fluxgs/cameras/cameras.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "camera/view_state.h"
#include "fluxgs/io/file.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

constexpr int kMaxImageSide = 16384;
constexpr double kDegree = std::numbers::pi / 180;

Expected<Camera> camera_from_json(const json& entry, const std::string& path, std::size_t index,
                                  const ImageSize& size) {
  const std::string where = fmt::format("camera {}", index);
  const auto vec = [&](const char* key) -> Expected<glm::dvec3> {
    const auto it = entry.find(key);
    const bool good = it != entry.end() && it->is_array() && it->size() == 3 &&
                      std::ranges::all_of(*it, [](const json& v) { return v.is_number(); });
    const glm::dvec3 v = good ? glm::dvec3((*it)[0], (*it)[1], (*it)[2]) : glm::dvec3(NAN);
    if (!(std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}) < 1e9))
      return fail(path, fmt::format("{}: {}", where, key), "expected three numbers below 1e9");
    return v;
  };
  if (!entry.is_object()) return fail(path, where, "expected an object");
  const auto position = vec("position"), target = vec("target"), up = vec("up");
  for (const auto* v : {&position, &target, &up})
    if (!*v) return std::unexpected(v->error());
  const auto fov = entry.find("fovY");
  if (fov == entry.end() || !fov->is_number() ||
      !(fov->get<double>() > 0.1 && fov->get<double>() < 179))
    return fail(path, where + ": fovY", "expected degrees between 0.1 and 179");
  if (glm::length(glm::cross(*target - *position, *up)) < 1e-12)
    return fail(path, where, "position, target and up do not span a view (they lie on one line)");
  Camera camera = look_at(*position, *target, *up, fov->get<double>() * kDegree, size);
  const auto name = entry.find("name");
  camera.name = name != entry.end() && name->is_string() ? name->get<std::string>()
                                                         : fmt::format("{:03}", index);
  if (camera.name.empty() || camera.name.find('/') != std::string::npos)
    return fail(path, where + ": name",
                "expected text without '/', as it becomes part of a file's name");
  return camera;
}

}  // namespace

Camera look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up, double fov_y,
               const ImageSize& size) {
  Camera c;
  c.width = size.width;
  c.height = size.height;
  c.fx = c.fy = 0.5 * size.height / std::tan(0.5 * fov_y);
  c.cx = 0.5 * size.width;
  c.cy = 0.5 * size.height;
  c.rotation = camera::look_rotation(target - eye, up);
  c.translation = -(c.rotation * eye);
  return c;
}

Expected<ImageSize> parse_size(const std::string& text) {
  ImageSize size;
  const char* end = text.data() + text.size();
  const auto [x, first] = std::from_chars(text.data(), end, size.width);
  const bool more = first == std::errc() && x != end && *x == 'x';
  const auto [rest, second] = more ? std::from_chars(x + 1, end, size.height)
                                   : std::from_chars_result{x, std::errc::invalid_argument};
  if (second != std::errc() || rest != end || size.width < 1 || size.height < 1 ||
      size.width > kMaxImageSide || size.height > kMaxImageSide)
    return fail("", "",
                fmt::format("'{}' is not a size, expected WIDTHxHEIGHT, 1 to {} each", text,
                            kMaxImageSide));
  return size;
}

Camera resized(Camera camera, const ImageSize& size) {
  if (size.width == 0) return camera;
  const double sx = static_cast<double>(size.width) / camera.width;
  const double sy = static_cast<double>(size.height) / camera.height;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx *= sx, camera.cx *= sx;
  camera.fy *= sy, camera.cy *= sy;
  return camera;
}

Expected<std::vector<Camera>> cameras_from_file(const std::string& path, const ImageSize& size) {
  const auto bytes = read_file(path, 64u << 20);
  if (!bytes) return std::unexpected(bytes.error());
  const char* text = reinterpret_cast<const char*>(bytes->data());
  const json list = json::parse(text, text + bytes->size(), nullptr, false);
  if (!list.is_array() || list.empty())
    return fail(
        path, "",
        std::string(list.is_discarded() ? "is not valid JSON" : "is no list of cameras") +
            "; expected [{\"name\", \"position\", \"target\", \"up\", \"fovY\" in degrees}, "
            "...]");
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < list.size(); ++i) {
    auto camera = camera_from_json(list[i], path, i, size);
    if (!camera) return std::unexpected(camera.error());
    if (std::ranges::count(cameras, camera->name, &Camera::name) > 0)
      return fail(path, fmt::format("camera {}: name", i),
                  fmt::format("'{}' is there twice, and would name the same file", camera->name));
    cameras.push_back(std::move(*camera));
  }
  return cameras;
}

}  // namespace fluxgs::cli
