#include "io/gltf/gltf_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/gltf_frame.h"
#include "io/gltf/glb_container.h"
#include "io/gltf/gltf_builder.h"
#include "io/json_text.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

constexpr double kLargest = 1e15;  // of a position that an image can be made from
constexpr double kMaxSkew = 1e-3;  // of the axes of a node, as a cosine
constexpr double kNearestAxis = 1e-9;

// Half a turn about z from the cloud to glTF, and about x between the axes of an OpenCV camera and
// those of glTF (y up, z backward). Each undoes itself, but for the quaternion's sign.
const glm::dquat kFrame(0, 0, 0, 1), kAxes(0, 1, 0, 0);

template <std::size_t N>
std::optional<std::array<double, N>> numbers(const json& list) {
  if (!list.is_array() || list.size() != N) return std::nullopt;
  std::array<double, N> result;
  for (std::size_t i = 0; i < N; ++i) {
    if (!list[i].is_number()) return std::nullopt;
    result[i] = list[i].get<double>();
    if (!(std::abs(result[i]) <= kLargest)) return std::nullopt;
  }
  return result;
}

struct Place {
  glm::dvec3 position{0.0};
  glm::dquat rotation{1, 0, 0, 0};
};

/// The entry of a list that an index names.
const json* entry(const json& document, const char* list, const json& index) {
  const json& entries = member(document, list);
  if (!entries.is_array() || !index.is_number_unsigned()) return nullptr;
  const auto i = index.get<std::uint64_t>();
  return i < entries.size() ? &entries[i] : nullptr;
}

std::optional<Place> place_of_matrix(const json& matrix) {
  const auto m = numbers<16>(matrix);  // by columns
  if (!m) return std::nullopt;
  glm::dmat3 axes;
  for (int c = 0; c < 3; ++c) {
    const auto at = static_cast<std::size_t>(4 * c);
    const glm::dvec3 axis((*m)[at], (*m)[at + 1], (*m)[at + 2]);
    const double length = glm::length(axis);
    if (!(length > kNearestAxis)) return std::nullopt;
    axes[c] = axis / length;
  }
  for (int c = 0; c < 3; ++c)
    if (std::abs(glm::dot(axes[c], axes[(c + 1) % 3])) > kMaxSkew) return std::nullopt;
  if (glm::determinant(axes) < 0) return std::nullopt;
  return Place{{(*m)[12], (*m)[13], (*m)[14]}, glm::normalize(glm::quat_cast(axes))};
}

std::optional<Place> place_of(const json& node) {
  if (const json& matrix = member(node, "matrix"); !matrix.is_null())
    return place_of_matrix(matrix);
  Place place;
  if (const json& translation = member(node, "translation"); !translation.is_null()) {
    const auto t = numbers<3>(translation);
    if (!t) return std::nullopt;
    place.position = {(*t)[0], (*t)[1], (*t)[2]};
  }
  if (const json& rotation = member(node, "rotation"); !rotation.is_null()) {
    const auto r = numbers<4>(rotation);
    if (!r) return std::nullopt;
    const glm::dquat q((*r)[3], (*r)[0], (*r)[1], (*r)[2]);
    if (!(glm::length(q) > kNearestAxis)) return std::nullopt;
    place.rotation = glm::normalize(q);
  }
  return place;
}

/// A direction of unit length; glTF's up where there is none.
glm::dvec3 up_of(const json& node) {
  const auto up = numbers<3>(member(member(node, "extras"), "up"));
  if (!up) return {0, 1, 0};
  const glm::dvec3 direction((*up)[0], (*up)[1], (*up)[2]);
  const double length = glm::length(direction);
  return length > kNearestAxis ? direction / length : glm::dvec3(0, 1, 0);
}

/// Width and height; zeros where there are none.
std::array<int, 2> image_size_of(const json& node) {
  constexpr double kLargestSide = 1e6;
  const auto size = numbers<2>(member(member(node, "extras"), "image_size"));
  if (!size || !((*size)[0] >= 1 && (*size)[1] >= 1) ||
      !((*size)[0] <= kLargestSide && (*size)[1] <= kLargestSide))
    return {};
  return {static_cast<int>((*size)[0]), static_cast<int>((*size)[1])};
}

std::optional<InitialView> view_of(const json& document, const json& node) {
  const json* camera = entry(document, "cameras", member(node, "camera"));
  if (camera == nullptr) return std::nullopt;
  const json& fov = member(member(*camera, "perspective"), "yfov");
  const auto place = place_of(node);
  if (!place || !fov.is_number()) return std::nullopt;
  const double fov_y = fov.get<double>();
  if (!(fov_y > 0 && fov_y < std::numbers::pi)) return std::nullopt;
  const auto [width, height] = image_size_of(node);
  return InitialView{.position = turn_position(place->position),
                     .orientation = glm::normalize(kFrame * place->rotation * kAxes),
                     .fov_y = fov_y,
                     .up = turn_position(up_of(node)),
                     .image_width = width,
                     .image_height = height};
}

const json* default_scene(const json& document) {
  const json& index = member(document, "scene");
  return entry(document, "scenes", index.is_null() ? json(0U) : index);
}

json list_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

bool is_finite(const glm::dvec3& v) {
  return std::abs(v.x) <= kLargest && std::abs(v.y) <= kLargest && std::abs(v.z) <= kLargest;
}

bool is_unit(double length) { return std::abs(length - 1) < kMaxSkew; }

}  // namespace

std::optional<InitialView> find_initial_view(const json& document) {
  const json* scene = default_scene(document);
  if (scene == nullptr) return std::nullopt;
  const json& nodes = member(*scene, "nodes");
  if (!nodes.is_array()) return std::nullopt;
  for (const json& index : nodes) {
    const json* node = entry(document, "nodes", index);
    if (node == nullptr) continue;
    if (auto view = view_of(document, *node)) return view;
  }
  return std::nullopt;
}

void add_initial_view(const InitialView& view, json& document) {
  json& cameras = document["cameras"];
  const std::size_t camera = cameras.size();
  cameras.push_back(
      {{"type", "perspective"}, {"perspective", {{"yfov", view.fov_y}, {"znear", 0.01}}}});
  const glm::dquat q = glm::normalize(kFrame * view.orientation * kAxes);
  json& nodes = document["nodes"];
  const std::size_t node = nodes.size();
  json extras = {{"up", list_of(turn_position(view.up))}};
  if (view.image_width > 0) extras["image_size"] = {view.image_width, view.image_height};
  nodes.push_back({{"camera", camera},
                   {"translation", list_of(turn_position(view.position))},
                   {"rotation", {q.x, q.y, q.z, q.w}},
                   {"extras", extras}});
  const std::size_t scene = document.value("scene", std::size_t{0});
  json& shown = document["scenes"][scene]["nodes"];
  if (shown.is_null()) shown = json::array();
  shown.insert(shown.begin(), node);
}

}  // namespace fluxgs::io

namespace fluxgs {

bool is_sound(const InitialView& view) {
  using namespace io;
  return is_finite(view.position) && is_finite(view.up) && is_unit(glm::length(view.up)) &&
         is_unit(glm::length(view.orientation)) && view.fov_y > 0 &&
         view.fov_y < std::numbers::pi && view.image_width >= 0 && view.image_height >= 0;
}

Expected<std::vector<std::byte>> with_initial_view(std::span<const std::byte> glb,
                                                   const InitialView& view,
                                                   const std::string& name) {
  using namespace io;
  if (!is_sound(view))
    return fail(name, "start view",
                "expected finite numbers, directions of unit length and an angle from 0 to pi");
  const MemoryBytes source(glb);
  std::vector<std::byte> room;
  const auto chunks = parse_glb_container(source, name, room);
  if (!chunks) return std::unexpected(chunks.error());
  if (auto ok = check_chunks_behind(source, *chunks, name); !ok) return std::unexpected(ok.error());
  auto document = parse_json_object(chunks->json, name, "JSON");
  if (!document) return std::unexpected(document.error());
  const json* scene = default_scene(*document);
  if (scene == nullptr || !scene->is_object())
    return fail(name, "scenes", "there is none; expected one to put a camera into");
  try {
    add_initial_view(view, *document);
  } catch (const json::exception&) {
    return fail(name, "cameras", "expected lists of cameras and nodes");
  }
  auto file = allocate_glb(*document, chunks->bin_bytes, name);
  if (!file) return std::unexpected(file.error());
  std::ranges::copy(glb.subspan(chunks->bin_at, chunks->bin_bytes),
                    file->bytes.begin() + static_cast<std::ptrdiff_t>(file->bin));
  return std::move(file->bytes);
}

}  // namespace fluxgs
