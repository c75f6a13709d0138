#include "io/gltf/gltf_builder.h"

#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "cloud/cloud_memory.h"
#include "io/gltf/glb_container.h"
#include "io/gltf/gltf_json.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

constexpr int kPoints = 0;

json asset() { return {{"version", "2.0"}, {"generator", "Flux-GS"}}; }

json json_of(const GltfPrimitive& primitive) {
  json extension = {{"kernel", "ellipse"},
                    {"colorSpace", "srgb_rec709_display"},
                    {"sortingMethod", "cameraDistance"},
                    {"projection", "perspective"}};
  if (!primitive.nested.is_null()) extension["extensions"] = primitive.nested;
  if (!primitive.extras.is_null()) extension["extras"] = primitive.extras;
  return {{"attributes", primitive.attributes},
          {"mode", kPoints},
          {"extensions", {{kSplatExtension, std::move(extension)}}}};
}

constexpr std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

}  // namespace

std::size_t GltfBuilder::add_view(std::size_t bytes, bool vertices, std::size_t stride) {
  views_.push_back({{"buffer", 0}, {"byteOffset", bin_bytes_}, {"byteLength", bytes}});
  if (vertices) views_.back()["target"] = kGltfArrayBuffer;
  if (stride > 0) views_.back()["byteStride"] = stride;
  bin_bytes_ += padded(bytes);
  return views_.size() - 1;
}

std::size_t GltfBuilder::add_accessor(json accessor) {
  accessors_.push_back(std::move(accessor));
  return accessors_.size() - 1;
}

json GltfBuilder::document(const std::vector<GltfMesh>& meshes, bool required) const {
  json used = json::array({kSplatExtension}), mesh_list = json::array(), nodes = json::array(),
       shown = json::array();
  for (const auto& entry : meshes.at(0).primitives.at(0).nested.items())
    used.push_back(entry.key());
  for (const GltfMesh& mesh : meshes) {
    json primitives = json::array();
    for (const GltfPrimitive& primitive : mesh.primitives) primitives.push_back(json_of(primitive));
    shown.push_back(nodes.size());
    nodes.push_back({{"mesh", mesh_list.size()}});
    if (mesh.scale != 1) nodes.back()["scale"] = {mesh.scale, mesh.scale, mesh.scale};
    mesh_list.push_back({{"primitives", std::move(primitives)}});
  }
  json root = {{"asset", asset()}, {"extensionsUsed", used}, {"scene", 0}};
  if (required) root["extensionsRequired"] = used;
  root["scenes"] = json::array({{{"nodes", std::move(shown)}}});
  root["nodes"] = std::move(nodes);
  root["buffers"] = json::array({{{"byteLength", bin_bytes_}}});
  root["bufferViews"] = views_;
  root["accessors"] = accessors_;
  root["meshes"] = std::move(mesh_list);
  return root;
}

json empty_gltf_document() {
  return {{"asset", asset()},
          {"extensionsUsed", json::array({kSplatExtension})},
          {"scene", 0},
          {"scenes", json::array({json::object()})}};
}

Expected<GlbOutput> allocate_glb(const json& document, std::size_t bin_bytes,
                                 const std::string& name) {
  std::string text = document.dump();
  text.resize(padded(text.size()), ' ');
  const std::uint64_t bin = bin_bytes > 0 ? kGlbChunkHeader + std::uint64_t{bin_bytes} : 0;
  const std::uint64_t total = kGlbHeader + kGlbChunkHeader + text.size() + bin;
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return fail(name, "size",
                fmt::format("needs {} bytes; a .glb holds less than 4 GiB (a .ply more)", total));
  }
  auto bytes = allocate_bytes(static_cast<std::size_t>(total), name);
  if (!bytes) return std::unexpected(bytes.error());
  std::byte* at = bytes->data();
  const auto put = [&at](const auto& value) {
    std::memcpy(at, &value, sizeof value);
    at += sizeof value;
  };
  put(kGlbMagic);
  put(std::uint32_t{2});
  put(static_cast<std::uint32_t>(total));
  put(static_cast<std::uint32_t>(text.size()));
  put(std::uint32_t{kGlbJson});
  std::memcpy(at, text.data(), text.size());
  at += text.size();
  if (bin > 0) {
    put(static_cast<std::uint32_t>(bin_bytes));
    put(std::uint32_t{kGlbBin});
  }
  const auto offset = static_cast<std::size_t>(at - bytes->data());
  return GlbOutput{std::move(*bytes), offset};
}

}  // namespace fluxgs::io
