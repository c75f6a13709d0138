#include "io/gltf/gltf_compact.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "codec/compact.h"
#include "fluxgs/networks/appearance.h"
#include "io/gltf/gltf_accessor.h"
#include "io/gltf/gltf_json.h"

namespace fluxgs::io {
namespace {

void read_floats(const tinygltf::Value& list, std::span<float> to) {
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] = static_cast<float>(list.Get(static_cast<int>(i)).GetNumberAsDouble());
}

// Names, counts and kinds were checked before (gltf_json.cpp).
networks::Normalisation normalisation_of(const tinygltf::Value& constants) {
  networks::Normalisation n;
  read_floats(constants.Get("center"), {&n.center.x, 3});
  read_floats(constants.Get("extent"), {&n.extent, 1});
  read_floats(constants.Get("logScaleMean"), {&n.log_scale_mean, 1});
  read_floats(constants.Get("logScaleDeviation"), {&n.log_scale_deviation, 1});
  read_floats(constants.Get("shMean"), n.sh_mean);
  read_floats(constants.Get("shDeviation"), n.sh_deviation);
  return n;
}

Expected<GltfNetworks> find_networks(const GltfCompressedPlace& place,
                                     const tinygltf::Value& networks) {
  GltfNetworks found{.psi = {}, .phi = {}, .normalisation = {}};
  for (const auto& [key, to] : {std::pair("psi", &found.psi), std::pair("phi", &found.phi)}) {
    if (!networks.Has(key)) continue;
    const int view = networks.Get(key).GetNumberAsInt();
    const auto model = find_view(place.model, view, place.buffers, place.name);
    if (!model) return std::unexpected(model.error());
    if (model->bytes == 0)
      return fail(place.name, fmt::format("{}: {}", place.field, key), "has no bytes");
    *to = *model;
  }
  found.normalisation = normalisation_of(networks.Get("normalisation"));
  return found;
}

/// Readers of other extensions go by the accessors, so they must say what is decoded.
Expected<void> check_attributes(const GltfCompressedPlace& place, int sh_degree) {
  std::vector<std::pair<std::string, int>> expected{{"POSITION", TINYGLTF_TYPE_VEC3}};
  for (const auto& [name, type] : {std::pair("ROTATION", TINYGLTF_TYPE_VEC4),
                                   {"SCALE", TINYGLTF_TYPE_VEC3},
                                   {"OPACITY", TINYGLTF_TYPE_SCALAR}})
    expected.emplace_back(fmt::format("{}:{}", kSplatExtension, name), type);
  for (int degree = 0; degree <= sh_degree; ++degree)
    for (int i = 0; i <= 2 * degree; ++i)
      expected.emplace_back(fmt::format("{}:SH_DEGREE_{}_COEF_{}", kSplatExtension, degree, i),
                            TINYGLTF_TYPE_VEC3);
  for (const auto& [semantic, type] : expected) {
    const auto found = place.primitive.attributes.find(semantic);
    if (found == place.primitive.attributes.end())
      return fail(place.name, place.field, fmt::format("attribute {} is missing", semantic));
    const GltfExpectation kind{semantic.c_str(), type, kFloat};
    if (auto ok = check_accessor(place.model, found->second, kind, place.name, place.field); !ok)
      return ok;
  }
  return {};
}

std::vector<std::byte> copy_of(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

bool has_energy(const GltfSplats& splats) {
  return splats.networks && splats.networks->psi.bytes > 0;
}

}  // namespace

Expected<GltfSplats> find_compact_splats(const GltfCompressedPlace& place,
                                         const tinygltf::Value& extension) {
  const int view = extension.Get(kCompressedView).GetNumberAsInt();
  auto splats = describe_compressed(place, view, kCompactExtension);
  if (!splats) return splats;
  splats->compression = GltfCompression::compact;
  if (auto ok = check_attributes(place, splats->sh_degree); !ok) return std::unexpected(ok.error());
  const std::size_t most = codec::max_splats(splats->compressed.bytes);
  if (splats->count > most)
    return fail(place.name, splats->compressed_field,
                fmt::format("{} splats in {} bytes, expected {} at most", splats->count,
                            splats->compressed.bytes, most));
  splats->version = extension.Get(kVersion).GetNumberAsInt();
  if (extension.Has(kChunk))
    splats->chunk = static_cast<std::size_t>(extension.Get(kChunk).GetNumberAsInt());
  if (!extension.Has(kNetworks)) return splats;
  if (splats->sh_degree != 1)
    return fail(
        place.name, splats->compressed_field,
        fmt::format("has networks and attributes of degree {}, expected 1", splats->sh_degree));
  auto networks = find_networks(place, extension.Get(kNetworks));
  if (!networks) return std::unexpected(networks.error());
  splats->networks = *networks;
  return splats;
}

Expected<SplatCloud> decode_compact_splats(const GltfSplats& from, const CompactBytes& bytes,
                                           const std::string& name) {
  std::vector<float> energy;
  auto cloud = codec::decode_compact(
      bytes.stream, from.count, from.sh_degree, has_energy(from) ? &energy : nullptr,
      from.version == kOldestCompactVersion ? codec::CellCoding::draco : codec::CellCoding::octree);
  if (!cloud) return fail(name, from.compressed_field, cloud.error().message());
  if (!from.networks) return cloud;
  // The networks know the scene in glTF's frame
  if (auto ok = networks::bake_appearance(*cloud, energy, {copy_of(bytes.psi), copy_of(bytes.phi)},
                                          from.networks->normalisation, name);
      !ok)
    return std::unexpected(ok.error());
  return cloud;
}

std::vector<std::pair<std::string, std::size_t>> compact_attribute_bytes(
    const GltfSplats& from, const CompactBytes& bytes) {
  auto sizes = codec::attribute_bytes(bytes.stream, from.sh_degree, has_energy(from));
  if (!sizes) return {};
  return std::move(*sizes);
}

}  // namespace fluxgs::io
