#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "activation.h"
#include "cloud_memory.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/math/sh_rotation.h"
#include "glb_container.h"
#include "gltf_document.h"
#include "gltf_frame.h"

namespace fluxgs {
namespace {

using namespace io;

// A document may show a mesh many times, at the cost of memory that its size does not announce.
constexpr std::size_t kFileBytesPerSplat = 8;

template <class T>
float load(const std::byte* at, bool normalized) {
  T value;
  std::memcpy(&value, at, sizeof value);
  if (!normalized) return static_cast<float>(value);
  // glTF 2.0, section 3.11: c/127, not less than −1, and so on.
  return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<T>::max()),
                  -1.0f);
}

float component(const GltfAttribute& a, std::size_t element, std::size_t index) {
  const std::byte* at = a.data + element * a.stride;
  switch (a.component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return load<std::int8_t>(at + index, a.normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load<std::uint8_t>(at + index, a.normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return load<std::int16_t>(at + 2 * index, a.normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(at + 2 * index, a.normalized);
    default:
      return load<float>(at + 4 * index, false);
  }
}

glm::vec3 vec3(const GltfAttribute& a, std::size_t i) {
  return {component(a, i, 0), component(a, i, 1), component(a, i, 2)};
}

// A node's transform with the turn into the frame of the cloud, for all splats of a primitive.
struct Placement {
  const GltfTransform& node;
  double log_scale;
  math::ShRotation harmonics;

  explicit Placement(const GltfTransform& transform)
      : node(transform), log_scale(std::log(transform.scale)) {
    const glm::dmat3 r = glm::mat3_cast(transform.rotation);  // r[column][row]
    harmonics = math::make_sh_rotation(
        {{r[0][0], r[1][0], r[2][0]}, {r[0][1], r[1][1], r[2][1]}, {r[0][2], r[1][2], r[2][2]}});
  }
};

void read_splat(const GltfSplats& from, std::size_t i, const Placement& place, SplatCloud& cloud,
                std::size_t to) {
  glm::vec3 position = vec3(from.position, i);
  glm::quat rotation(component(from.rotation, i, 3), component(from.rotation, i, 0),
                     component(from.rotation, i, 1), component(from.rotation, i, 2));
  if (!place.node.identity) {
    position = place.node.linear * glm::dvec3(position) + place.node.translation;
    rotation = glm::quat(place.node.rotation * glm::dquat(rotation));
  }
  cloud.positions[to] = turn_position(position);
  cloud.rotations[to] = turn_from_gltf(rotation);
  const glm::vec3 scale = vec3(from.scale, i);
  for (int c = 0; c < 3; ++c) {
    cloud.log_scales[to][c] = static_cast<float>(log_scale(scale[c]) + place.log_scale);
  }
  cloud.opacity_logits[to] = logit(component(from.opacity, i, 0));
  cloud.sh_dc[to] = vec3(from.sh[0], i);
  // Bands that this primitive lacks stay zero.
  const auto own = static_cast<std::size_t>(sh_rest_count(from.sh_degree));
  glm::vec3* sh =
      cloud.sh_rest.data() + to * static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < own; ++k) sh[k] = vec3(from.sh[k + 1], i);
  if (!place.node.identity) math::rotate_sh(place.harmonics, from.sh_degree, sh);
  for (std::size_t k = 0; k < own; ++k) sh[k] *= turn_sign(k);
}

Expected<std::size_t> count_splats(const std::vector<GltfInstance>& instances, std::size_t file,
                                   const std::string& name) {
  std::size_t total = 0;
  for (const GltfInstance& instance : instances) {
    // Every count is at most the size of the file, and there are at most 65,536 of them.
    total += instance.splats.count;
    if (total <= file / kFileBytesPerSplat) continue;
    return fail(name, "nodes",
                fmt::format("show more than {} splats by repeating meshes; a file of {} bytes may "
                            "hold one per {} bytes",
                            file / kFileBytesPerSplat, file, kFileBytesPerSplat));
  }
  return total;
}

Expected<SceneFile> read(std::span<const std::byte> bytes, const std::string& name) {
  const auto chunks = parse_glb_container(bytes, name);
  if (!chunks) return std::unexpected(chunks.error());
  const auto json = check_gltf_json(chunks->json, chunks->bin.size(), name);
  if (!json) return std::unexpected(json.error());
  const auto instances = find_gltf_splats(*json, chunks->bin, name);
  if (!instances) return std::unexpected(instances.error());
  if (instances->empty() &&
      std::ranges::find(json->extensions_used, kSplatExtension) == json->extensions_used.end()) {
    return fail(name, "meshes",
                fmt::format("no primitive has {}; expected splats", kSplatExtension));
  }
  const auto total = count_splats(*instances, bytes.size(), name);
  if (!total) return std::unexpected(total.error());
  int degree = 0;
  for (const GltfInstance& instance : *instances) {
    degree = std::max(degree, instance.splats.sh_degree);
  }
  auto cloud = allocate_cloud(*total, degree, name);
  if (!cloud) return std::unexpected(cloud.error());
  std::size_t next = 0;
  for (const GltfInstance& instance : *instances) {
    const Placement place(instance.transform);
    for (std::size_t i = 0; i < instance.splats.count; ++i) {
      read_splat(instance.splats, i, place, *cloud, next++);
    }
  }
  SceneFile scene;
  scene.cloud = std::move(*cloud);
  scene.dropped = drop_non_finite(scene.cloud);
  scene.format = "glb";
  scene.extensions = json->extensions_used;
  scene.attribute_bits = float_attribute_bits(scene.cloud.sh_degree);
  scene.bytes = bytes.size();
  return scene;
}

}  // namespace

bool is_glb(std::span<const std::byte> bytes) {
  return bytes.size() >= sizeof kGlbMagic &&
         std::memcmp(bytes.data(), kGlbMagic, sizeof kGlbMagic) == 0;
}

Expected<SceneFile> read_glb(std::span<const std::byte> bytes, const std::string& name) {
  try {
    return read(bytes, name);
  } catch (const std::bad_alloc&) {
    return fail(name, "memory",
                fmt::format("out of memory parsing a .glb of {} bytes", bytes.size()));
  }
}

}  // namespace fluxgs
