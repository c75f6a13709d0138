#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "cloud/activation.h"
#include "cloud/cloud_memory.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/gltf_frame.h"
#include "fluxgs/math/sh_rotation.h"
#include "io/gltf/glb_container.h"
#include "io/gltf/gltf_compact.h"
#include "io/gltf/gltf_document.h"
#include "io/gltf/gltf_spz.h"

namespace fluxgs {
namespace {

using namespace io;

// A document may show a mesh many times, at the cost of memory that its size does not announce.
constexpr std::size_t kFileBytesPerSplat = 8;
// Compressed by SPZ, it may be more: the bounds of spz.h, over all meshes of the file.
constexpr std::size_t kAlwaysAllowed = std::size_t(1) << 20, kCompressedPerFileByte = 2;
// And time: compressed meshes are decoded for each node that shows them.
constexpr std::size_t kMaxDecoding = 8;

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
  math::ShRotation sh;

  explicit Placement(const GltfTransform& transform)
      : node(transform), log_scale(std::log(transform.scale)) {
    const glm::dmat3 r = glm::mat3_cast(transform.rotation);  // r[column][row]
    sh = math::make_sh_rotation(
        {{r[0][0], r[1][0], r[2][0]}, {r[0][1], r[1][1], r[2][1]}, {r[0][2], r[1][2], r[2][2]}});
  }
};

// True if SCALE holds logarithms, as a draft of KHR_gaussian_splatting had it and splat-transform
// wrote until its version 2.6: scales are never negative, and logarithms of most splats are.
bool has_log_scales(const GltfSplats& splats) {
  std::size_t negative = 0;
  for (std::size_t i = 0; i < splats.count; ++i)
    for (int c = 0; c < 3; ++c) negative += component(splats.scale, i, c) < 0;
  return negative > 0 && 2 * negative >= 3 * splats.count;
}

// A splat as the attributes say it, in glTF's frame.
SplatValues load_splat(const GltfSplats& from, bool log_scales, std::size_t i) {
  SplatValues splat{};
  splat.position = vec3(from.position, i);
  splat.rotation = glm::quat(component(from.rotation, i, 3), component(from.rotation, i, 0),
                             component(from.rotation, i, 1), component(from.rotation, i, 2));
  const glm::vec3 scale = vec3(from.scale, i);
  for (int c = 0; c < 3; ++c)
    splat.log_scale[c] = log_scales ? scale[c] : static_cast<float>(log_scale(scale[c]));
  splat.opacity_logit = logit_of(component(from.opacity, i, 0));
  splat.sh_dc = vec3(from.sh[0], i);
  const auto rest = static_cast<std::size_t>(sh_rest_count(from.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) splat.sh_rest[k] = vec3(from.sh[k + 1], i);
  return splat;
}

// From glTF's frame through the node into that of the cloud.
void place_splat(const Placement& place, int sh_degree, SplatValues& splat) {
  if (!place.node.identity) {
    splat.position = place.node.linear * glm::dvec3(splat.position) + place.node.translation;
    splat.rotation = glm::quat(place.node.rotation * glm::dquat(splat.rotation));
    for (int c = 0; c < 3; ++c) {
      splat.log_scale[c] = static_cast<float>(double{splat.log_scale[c]} + place.log_scale);
    }
    math::rotate_sh(place.sh, sh_degree, splat.sh_rest.data());
  }
  splat.position = turn_position(splat.position);
  splat.rotation = turn_from_gltf(splat.rotation);
  const auto rest = static_cast<std::size_t>(sh_rest_count(sh_degree));
  for (std::size_t k = 0; k < rest; ++k) splat.sh_rest[k] *= turn_sign(k);
}

SplatValues load_splat(const SplatCloud& from, std::size_t i) {
  SplatValues splat{};
  splat.position = from.positions[i];
  splat.rotation = from.rotations[i];
  splat.log_scale = from.log_scales[i];
  splat.opacity_logit = from.opacity_logits[i];
  splat.sh_dc = from.sh_dc[i];
  const auto rest = static_cast<std::size_t>(sh_rest_count(from.sh_degree));
  std::copy_n(from.sh_rest.data() + i * rest, rest, splat.sh_rest.data());
  return splat;
}

// Appends the splats of one primitive at `next`.
Expected<void> read_instance(const GltfInstance& instance, const std::string& name,
                             SplatCloud& cloud, std::size_t& next) {
  const GltfSplats& from = instance.splats;
  const Placement place(instance.transform);
  const auto rest = static_cast<std::size_t>(sh_rest_count(from.sh_degree));
  const auto append = [&](SplatValues& splat) {
    place_splat(place, from.sh_degree, splat);
    store_splat(splat, rest, cloud, next++);
  };
  if (from.compression == GltfCompression::none) {
    const bool log_scales = has_log_scales(from);
    for (std::size_t i = 0; i < from.count; ++i) {
      SplatValues splat = load_splat(from, log_scales, i);
      append(splat);
    }
    return {};
  }
  if (from.compression == GltfCompression::compact) {
    const auto decoded = decode_compact_splats(from, name);
    if (!decoded) return std::unexpected(decoded.error());
    for (std::size_t i = 0; i < from.count; ++i) {
      SplatValues splat = load_splat(*decoded, i);
      append(splat);
    }
    return {};
  }
  const SpzSource source{from.compressed, name, from.compressed_field};
  const auto header = read_spz_header(source);
  if (!header) return std::unexpected(header.error());
  const auto packed = unpack_spz(source, *header);
  if (!packed) return std::unexpected(packed.error());
  const AxisFlip flip = make_axis_flip(spz_signs_in_gltf(*packed, from.bounds));
  SplatValues splat{};
  for (std::size_t i = 0; i < from.count; ++i) {
    read_spz_splat(*packed, i, flip, splat);
    append(splat);
  }
  return {};
}

// How many splats there are in all, within the bounds on repeated meshes. Networks are run for
// every node that shows them, which may take seconds: they belong to scenes of one primitive.
Expected<std::size_t> count_splats(const std::vector<GltfInstance>& instances, std::size_t file,
                                   const std::string& name) {
  const std::size_t max_plain = file / kFileBytesPerSplat;
  const std::size_t max_compressed = std::max(kAlwaysAllowed, kCompressedPerFileByte * file);
  std::size_t plain = 0, compressed = 0, decoded = 0;
  for (const GltfInstance& instance : instances) {
    const GltfSplats& splats = instance.splats;
    if (splats.networks && instances.size() > 1)
      return fail(name, "nodes",
                  fmt::format("show {} primitives, expected one where networks make the colours",
                              instances.size()));
    // Every count has 32 bits or is at most the size of the file, and there are at most 65,536.
    (splats.compression == GltfCompression::none ? plain : compressed) += splats.count;
    decoded += splats.compressed.size();
    if (plain <= max_plain && compressed <= max_compressed && decoded <= kMaxDecoding * file) {
      continue;
    }
    return fail(name, "nodes",
                fmt::format("show more splats by repeating meshes than a file of {} bytes may: {}, "
                            "compressed {}, decoding {} bytes",
                            file, max_plain, max_compressed, kMaxDecoding * file));
  }
  return plain + compressed;
}

// SPZ's attributes cannot be told apart.
AttributeBits bits_of(const std::vector<GltfInstance>& instances, int sh_degree) {
  AttributeBits bits;
  double splats = 0;
  for (const GltfInstance& instance : instances) {
    const GltfSplats& from = instance.splats;
    splats += static_cast<double>(from.count);
    if (from.compression == GltfCompression::spz)
      bits["spz"] += 8 * static_cast<double>(from.compressed.size());
    if (from.compression != GltfCompression::compact) continue;
    for (const auto& [attribute, bytes] : compact_attribute_bytes(from))
      bits[attribute] += 8 * static_cast<double>(bytes);
  }
  if (bits.empty()) return float_attribute_bits(sh_degree);
  for (auto& [attribute, sum] : bits) sum /= std::max(splats, 1.0);
  return bits;
}

// All instances in one cloud.
Expected<SplatCloud> read_instances(const std::vector<GltfInstance>& instances, std::size_t total,
                                    const std::string& name) {
  // What most files hold needs no second copy
  if (instances.size() == 1 && instances[0].transform.identity &&
      instances[0].splats.compression == GltfCompression::compact) {
    auto cloud = decode_compact_splats(instances[0].splats, name);
    if (cloud) turn_cloud(*cloud);
    return cloud;
  }
  int degree = 0;
  for (const GltfInstance& instance : instances) {
    degree = std::max(degree, instance.splats.sh_degree);
  }
  auto cloud = allocate_cloud(total, degree, name);
  if (!cloud) return cloud;
  std::size_t next = 0;
  for (const GltfInstance& instance : instances) {
    if (auto ok = read_instance(instance, name, *cloud, next); !ok) {
      return std::unexpected(ok.error());
    }
  }
  return cloud;
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
  auto cloud = read_instances(*instances, *total, name);
  if (!cloud) return std::unexpected(cloud.error());
  SceneFile scene;
  scene.cloud = std::move(*cloud);
  scene.dropped = drop_non_finite(scene.cloud);
  scene.format = "glb";
  scene.extensions = json->extensions_used;
  scene.start = json->start;
  scene.attribute_bits = bits_of(*instances, scene.cloud.sh_degree);
  scene.bytes = bytes.size();
  return scene;
}

}  // namespace

void turn_gltf_frame(SplatCloud& cloud) { turn_cloud(cloud); }

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
