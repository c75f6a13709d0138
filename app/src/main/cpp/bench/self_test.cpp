#include "bench/self_test.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "camera/initial_view.h"
#include "camera/orbit.h"
#include "fluxgs/hash.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/math/projection.h"
#include "render/scene_packing.h"
#include "render/sort_view.h"
#include "sort/sort_thread.h"

namespace fluxgs::bench {
namespace {

class Hash {
 public:
  template <class T>
  void add(const std::vector<T>& values) {
    add(std::as_bytes(std::span(values)));
  }
  void add(std::span<const std::byte> bytes) { value_ = fnv1a(bytes, value_); }
  template <class T>
  void add_value(const T& value) {
    add(std::as_bytes(std::span(&value, 1)));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = kFnv1aOffset;
};

std::uint64_t hash_of(const render::RenderCloud& cloud) {
  Hash hash;
  hash.add_value(cloud.sh_degree);
  hash.add(cloud.base.positions);
  hash.add(cloud.base.log_scales);
  hash.add(cloud.base.rotations);
  hash.add(cloud.base.opacity_logits);
  hash.add(cloud.base.sh_dc);
  hash.add(cloud.sh);
  return hash.value();
}

/// Along the axes: no angle functions, whose last bits differ between C libraries.
std::vector<Camera> views_of(const render::RenderCloud& cloud) {
  glm::vec3 low(0), high(0);
  for (const glm::vec3& p : cloud.base.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::dvec3 middle = 0.5 * (glm::dvec3(low) + glm::dvec3(high));
  const glm::dvec3 extent = glm::dvec3(high) - glm::dvec3(low);
  const double size = std::max({extent.x, extent.y, extent.z, 1e-3});
  std::vector<Camera> views;
  for (int axis = 0; axis < 3; ++axis) {
    Camera& view = views.emplace_back();
    view.width = 640;
    view.height = 480;
    view.fx = view.fy = 500;
    view.cx = 320;
    view.cy = 240;
    for (int row = 0; row < 3; ++row)  // the axis is forward
      for (int column = 0; column < 3; ++column)
        view.rotation[column][row] = column == (axis + 1 + row) % 3 ? 1 : 0;
    glm::dvec3 eye = middle;
    eye[axis] -= 1.5 * size;
    view.translation = -(view.rotation * eye);
  }
  return views;
}

std::vector<glm::vec3> positions_of(render::ScenePacker& packer) {
  std::vector<glm::vec3> positions;
  render::pack_in_parts(packer, &positions, [](const render::PackedSplats&) {});
  return positions;
}

std::uint64_t sorted_hash(const render::RenderCloud& cloud, const std::vector<Camera>& views) {
  render::ScenePacker packer(cloud);
  const render::SceneConstants& scene = packer.constants();
  sort::SortThread thread(positions_of(packer));
  Hash hash;
  for (const Camera& view : views) {
    const sort::SharedIndices order =
        thread.wait(thread.request(render::sort_view(view, 0.01, scene, sort::kMaxKeyBits)));
    hash.add_value(order->count);
    hash.add(std::as_bytes(std::span(order->indices).first(order->count)));
  }
  return hash.value();
}

std::uint64_t projected_hash(const render::RenderCloud& cloud, const std::vector<Camera>& views) {
  using math::Vec3;
  Hash hash;
  for (const Camera& camera : views) {
    const auto view = math::make_view<float>(camera, for_scene({}, cloud.base.filter));
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::vec3& p = cloud.base.positions[i];
      const Vec3<float> at = view.rotation * Vec3<float>{p.x, p.y, p.z} + view.translation;
      if (!(at.z > view.near_plane)) continue;
      const auto jacobian = math::projection_jacobian(at, view);
      const glm::quat& q = cloud.base.rotations[i];
      const auto turn =
          math::rotation_matrix(math::normalized(math::Quat<float>{q.w, q.x, q.y, q.z}));
      const float numbers[] = {jacobian.x0,      jacobian.x2,     jacobian.y1, jacobian.y2,
                               turn.row0.x,      turn.row1.y,     turn.row2.z, turn.row0.z,
                               jacobian.slope_x, jacobian.slope_y};
      hash.add(std::as_bytes(std::span(numbers)));
    }
  }
  return hash.value();
}

std::string result_of(std::span<const std::byte> bytes) {
  const auto error = [](const std::string& text) {
    return nlohmann::json{{"error", text}}.dump(-1, ' ', false,
                                                nlohmann::json::error_handler_t::replace);
  };
  try {
    auto scene = read_scene(bytes, "scene");
    if (!scene) return error(scene.error().message());
    return to_json(self_test(render::cloud_to_draw(std::move(scene->cloud))));
  } catch (const std::exception& problem) {
    return error(problem.what());
  }
}

}  // namespace

SelfTest self_test(const render::RenderCloud& cloud) {
  const std::vector<Camera> views = views_of(cloud);
  return {.splats = cloud.size(),
          .decoded = hash_of(cloud),
          .sorted = sorted_hash(cloud, views),
          .projected = projected_hash(cloud, views)};
}

std::string to_json(const SelfTest& result) {
  return fmt::format(
      R"({{"splats": {}, "decoded": "{:016x}", "sorted": "{:016x}", "projected": "{:016x}"}})",
      result.splats, result.decoded, result.sorted, result.projected);
}

}  // namespace fluxgs::bench

std::size_t fluxgs_self_test(const std::uint8_t* scene, std::size_t bytes, char* json,
                             std::size_t room) {
  const std::string text =
      fluxgs::bench::result_of(std::as_bytes(std::span(scene, scene ? bytes : 0)));
  if (room > 0) {
    const std::size_t kept = std::min(text.size(), room - 1);
    std::memcpy(json, text.data(), kept);
    json[kept] = 0;
  }
  return text.size();
}
