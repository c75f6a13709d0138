#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "cloud/activation.h"
#include "cloud/cloud_memory.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/gltf_frame.h"
#include "fluxgs/transform.h"
#include "io/gltf/glb_container.h"
#include "io/gltf/gltf_colour.h"
#include "io/gltf/gltf_compact.h"
#include "io/gltf/gltf_document.h"
#include "io/gltf/gltf_spz.h"
#include "io/json_text.h"
#include "io/sog/folder_files.h"
#include "io/whole_cloud.h"

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

// The splats of one compact primitive, in its own frame.
Expected<SplatCloud> read_compact(const GltfSplats& from, GltfBuffers& buffers,
                                  const std::string& name, AttributeBits& bits) {
  CompactBytes bytes;
  std::array<std::vector<std::byte>, 3> rooms;
  const GltfNetworks none{};
  const GltfNetworks& networks = from.networks ? *from.networks : none;
  for (const auto& [view, to, room] : {std::tuple(&networks.psi, &bytes.psi, &rooms[0]),
                                       {&networks.phi, &bytes.phi, &rooms[1]},
                                       {&from.compressed, &bytes.stream, &rooms[2]}}) {
    const auto read = view->bytes > 0 ? buffers.read(*view, *room) : std::span<const std::byte>();
    if (!read) return std::unexpected(read.error());
    *to = *read;
  }
  for (const auto& [attribute, count] : compact_attribute_bytes(from, bytes))
    bits[attribute] += 8 * static_cast<double>(count);
  return decode_compact_splats(from, bytes, name);
}

// Appends the splats of one primitive at `next`, in its own frame and colours.
Expected<void> read_primitive(const GltfSplats& from, GltfBuffers& buffers, const std::string& name,
                              SplatCloud& cloud, std::size_t& next, AttributeBits& bits) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(from.sh_degree));
  const auto append = [&](const SplatValues& splat) { store_splat(splat, rest, cloud, next++); };
  if (from.compression == GltfCompression::none) {
    const bool log_scales = has_log_scales(from);
    for (std::size_t i = 0; i < from.count; ++i) {
      append(load_splat(from, log_scales, i));
    }
    return {};
  }
  if (from.compression == GltfCompression::compact) {
    const auto decoded = read_compact(from, buffers, name, bits);
    if (!decoded) return std::unexpected(decoded.error());
    for (std::size_t i = 0; i < from.count; ++i) {
      append(load_splat(*decoded, i));
    }
    return {};
  }
  std::vector<std::byte> room;
  const auto bytes = buffers.read(from.compressed, room);
  if (!bytes) return std::unexpected(bytes.error());
  const SpzSource source{*bytes, name, from.compressed_field};
  const auto header = read_spz_header(source);
  if (!header) return std::unexpected(header.error());
  const auto packed = unpack_spz(source, *header);
  if (!packed) return std::unexpected(packed.error());
  if ((packed->header.flags & kSpzAntialiased) != 0) cloud.filter.compensated = true;
  const AxisFlip flip = make_axis_flip(spz_signs_in_gltf(*packed, from.bounds));
  SplatValues splat{};
  for (std::size_t i = 0; i < from.count; ++i) {
    read_spz_splat(*packed, i, flip, splat);
    append(splat);
  }
  return {};
}

// Networks are run for every primitive that is shown, which may take seconds: a scene has one, or
// one a chunk with the same networks.
bool may_run_networks(const std::vector<GltfInstance>& instances) {
  constexpr std::size_t kMostRuns = 16;
  if (std::ranges::none_of(instances, [](const auto& i) { return i.splats.networks.has_value(); }))
    return true;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const GltfSplats &own = instances[i].splats, &first = instances[0].splats;
    if (own.chunk != i || !own.networks || !first.networks ||
        own.networks->psi != first.networks->psi || own.networks->phi != first.networks->phi)
      return false;
  }
  return instances.size() <= kMostRuns;
}

// The number of splats in all, within the bounds on repeated meshes.
Expected<std::size_t> count_splats(const std::vector<GltfInstance>& instances, std::size_t file,
                                   const std::string& name) {
  const std::size_t max_plain = file / kFileBytesPerSplat;
  const std::size_t max_compressed = std::max(kAlwaysAllowed, kCompressedPerFileByte * file);
  std::size_t plain = 0, compressed = 0, decoded = 0;
  if (!may_run_networks(instances))
    return fail(name, "nodes",
                fmt::format("show {} primitives, expected one where networks make the colours",
                            instances.size()));
  for (const GltfInstance& instance : instances) {
    const GltfSplats& splats = instance.splats;
    // Every count has 32 bits or is at most the size of the file, and there are at most 65,536.
    (splats.compression == GltfCompression::none ? plain : compressed) += splats.count;
    decoded += splats.compressed.bytes;
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

void add_plain_bits(const GltfSplats& from, AttributeBits& bits) {
  const auto add = [&](const char* name, const GltfAttribute& attribute, int components) {
    const int bytes =
        tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(attribute.component_type));
    bits[name] += 8.0 * bytes * components * static_cast<double>(from.count);
  };
  add("position", from.position, 3);
  add("rotation", from.rotation, 4);
  add("scale", from.scale, 3);
  add("opacity", from.opacity, 1);
  add("sh_dc", from.sh[0], 3);
  const auto rest = static_cast<std::size_t>(sh_rest_count(from.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) add("sh_rest", from.sh[k + 1], 3);
}

// Bits a splat. `bits`: sums of what the streams of compact primitives tell. SPZ's attributes
// cannot be told apart.
AttributeBits bits_of(const std::vector<GltfInstance>& instances, int sh_degree,
                      AttributeBits bits) {
  double splats = 0;
  for (const auto& [from, transform] : instances) {
    splats += static_cast<double>(from.count);
    if (from.compression == GltfCompression::none) add_plain_bits(from, bits);
    if (from.compression == GltfCompression::spz)
      bits["spz"] += 8 * static_cast<double>(from.compressed.bytes);
  }
  if (!instances.empty() && instances[0].splats.networks) {
    const GltfNetworks& networks = *instances[0].splats.networks;  // those of all
    bits["networks"] = 8 * static_cast<double>(networks.psi.bytes + networks.phi.bytes);
  }
  if (bits.empty()) return float_attribute_bits(sh_degree);
  for (auto& [attribute, sum] : bits) sum /= std::max(splats, 1.0);
  return bits;
}

// The splats of one instance, of its own degree, in the frame of a SplatCloud.
Expected<SplatCloud> read_instance(const GltfInstance& instance, GltfBuffers& buffers,
                                   const std::string& name, AttributeBits& bits) {
  const GltfSplats& splats = instance.splats;
  // What most files hold needs no second copy
  if (instance.transform == AffineMap{} && splats.compression == GltfCompression::compact &&
      !splats.linear_colours) {
    auto cloud = read_compact(splats, buffers, name, bits);
    if (cloud) turn_cloud(*cloud);
    return cloud;
  }
  auto cloud = allocate_cloud(splats.count, splats.sh_degree, name);
  if (!cloud) return cloud;
  std::size_t next = 0;
  if (auto ok = read_primitive(splats, buffers, name, *cloud, next, bits); !ok)
    return std::unexpected(ok.error());
  if (splats.linear_colours) encode_linear_colours(*cloud, 0, next);
  transform_splats(instance.transform, *cloud, 0, next);
  turn_splats(*cloud, 0, next, splats.sh_degree);
  return cloud;
}

// As many as there are to be: all, and their highest degree. What is held is the largest instance.
ComingSplats coming_from(const std::vector<GltfInstance>& instances, std::size_t total) {
  ComingSplats coming{.count = total};
  for (const auto& [splats, transform] : instances) {
    coming.sh_degree = std::max(coming.sh_degree, splats.sh_degree);
    coming.held =
        std::max<std::uint64_t>(coming.held, splat_memory_bytes(splats.count, splats.sh_degree));
  }
  return coming;
}

// The chunks of a scene by importance. Where a mesh is shown twice, there is one.
std::vector<SceneChunk> chunks_of(const GltfDocument& document) {
  const std::vector<GltfInstance>& instances = document.instances;
  const auto number = [](const GltfInstance& instance) { return instance.splats.chunk; };
  const bool in_order = std::ranges::is_sorted(instances, {}, number);
  std::vector<SceneChunk> chunks;
  for (const GltfInstance& instance : instances) {
    const GltfSplats& splats = instance.splats;
    if (chunks.empty() || (in_order && splats.chunk == chunks.size())) chunks.emplace_back();
    chunks.back().splats += splats.count;
    chunks.back().end = static_cast<std::size_t>(document.chunks.bin_at) + splats.compressed.end();
  }
  if (chunks.size() <= 1) chunks.clear();
  return chunks;
}

// Tells the sink of every chunk but the last.
Expected<void> read_instances(GltfDocument& document, std::size_t total, const std::string& name,
                              SplatSink& sink, SceneFile& scene) {
  const std::vector<GltfInstance>& instances = document.instances;
  const auto degree = sink.begin(coming_from(instances, total));
  if (!degree) return std::unexpected(degree.error());
  scene.cloud.sh_degree = *degree;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    auto part = read_instance(instances[i], document.buffers, name, scene.attribute_bits);
    if (!part) return std::unexpected(part.error());
    if (part->filter.compensated && !document.json.filter) scene.cloud.filter.compensated = true;
    limit_sh_degree(*part, *degree);
    scene.dropped += drop_non_finite(*part);
    if (auto taken = sink.take(*part); !taken) return taken;
    const bool ends_chunk =
        i + 1 < instances.size() && instances[i].splats.chunk < instances[i + 1].splats.chunk;
    if (ends_chunk && !scene.chunks.empty()) sink.chunk_came(scene);
  }
  return {};
}

Expected<SceneFile> read(const ByteSource& file, const NamedFiles& files, const std::string& name,
                         SplatSink& sink) {
  auto document = open_gltf(file, files, name);
  if (!document) return std::unexpected(document.error());
  const std::vector<GltfInstance>& instances = document->instances;
  const GltfJson& json = document->json;
  if (instances.empty() &&
      std::ranges::find(json.extensions_used, kSplatExtension) == json.extensions_used.end()) {
    return fail(name, "meshes",
                fmt::format("no primitive has {}: it holds no splats, but the meshes of a model or "
                            "nothing; expected splats",
                            kSplatExtension));
  }
  const std::size_t size = document->buffers.bytes();
  const auto total = count_splats(instances, size, name);
  if (!total) return std::unexpected(total.error());
  SceneFile scene;
  if (json.filter) scene.cloud.filter = *json.filter;
  scene.start = json.start;
  scene.chunks = chunks_of(*document);
  if (auto done = read_instances(*document, *total, name, sink, scene); !done)
    return std::unexpected(done.error());
  if (document->chunks.behind > 0)
    if (auto ok = check_chunks_behind(file, document->chunks, name); !ok)
      return std::unexpected(ok.error());
  scene.format = "glb";
  scene.extensions = json.extensions_used;
  scene.warnings = document->warnings;
  if (instances.empty() && json.reduced.contains("\"meshes\":[{"))
    scene.warnings.push_back(
        fmt::format("names {}, but no node of its scene has a primitive with it", kSplatExtension));
  scene.attribute_bits =
      bits_of(instances, coming_from(instances, *total).sh_degree, std::move(scene.attribute_bits));
  scene.bytes = size;
  return scene;
}

// Parsing takes memory that is not asked for as a value.
Expected<SceneFile> read_within_memory(const ByteSource& file, const NamedFiles& files,
                                       const std::string& name, SplatSink& sink) {
  try {
    return read(file, files, name, sink);
  } catch (const std::bad_alloc&) {
    return fail(name, "memory", fmt::format("out of memory parsing {} bytes", file.size()));
  }
}

}  // namespace

void turn_gltf_frame(SplatCloud& cloud) { turn_cloud(cloud); }

bool is_glb(std::span<const std::byte> bytes) {
  return bytes.size() >= sizeof kGlbMagic &&
         std::memcmp(bytes.data(), kGlbMagic, sizeof kGlbMagic) == 0;
}

Expected<std::vector<SceneChunk>> find_chunks(const ByteSource& file, const std::string& name) {
  const auto is_one = begins_as_glb(file);
  if (!is_one) return std::unexpected(is_one.error());
  if (!*is_one) return std::vector<SceneChunk>();
  const auto document = open_gltf(file, {}, name);
  if (!document) return std::unexpected(document.error());
  return chunks_of(*document);
}

std::optional<std::uint64_t> size_of_glb(std::span<const std::byte> begin) {
  if (!is_glb(begin) || begin.size() < kGlbHeader) return std::nullopt;
  std::uint32_t size = 0;
  std::memcpy(&size, begin.data() + kGlbHeader - sizeof size, sizeof size);
  return size;
}

bool is_gltf(std::span<const std::byte> bytes) {
  std::string_view text = as_text(bytes.first(std::min(bytes.size(), kMaxJsonText)));
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin != text.npos && text[begin] == '{' && text.contains("\"asset\"") &&
         (text.contains("\"meshes\"") || text.contains("\"scenes\""));
}

Expected<SceneFile> read_glb(const ByteSource& file, const std::string& name, SplatSink& sink) {
  const auto is_one = begins_as_glb(file);
  std::vector<std::byte> room;
  if (!is_one) return std::unexpected(is_one.error());
  if (!*is_one) return std::unexpected(parse_glb_container(file, name, room).error());
  return read_within_memory(file, {}, name, sink);
}

Expected<SceneFile> read_glb(std::span<const std::byte> bytes, const std::string& name) {
  return read_whole(name,
                    [&](SplatSink& sink) { return read_glb(MemoryBytes(bytes), name, sink); });
}

Expected<SceneFile> read_gltf(std::span<const std::byte> bytes, const std::string& name,
                              SplatSink& sink) {
  return read_within_memory(MemoryBytes(bytes), {}, name, sink);
}

Expected<SceneFile> read_gltf(std::span<const std::byte> bytes, const std::string& name) {
  return read_whole(name, [&](SplatSink& sink) { return read_gltf(bytes, name, sink); });
}

Expected<SceneFile> read_gltf_folder(std::span<const std::byte> bytes,
                                     const std::filesystem::path& path) {
  FolderFiles folder(path.parent_path());
  const NamedFiles files = [&folder](const std::string& file, std::uint64_t max_bytes) {
    return folder.read(file, max_bytes);
  };
  const std::string name = path.string();
  return read_whole(name, [&](SplatSink& sink) {
    return read_within_memory(MemoryBytes(bytes), files, name, sink);
  });
}

}  // namespace fluxgs
