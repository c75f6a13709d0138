#include <numeric>

#include <fmt/format.h>

#include "cloud/cloud_memory.h"
#include "fluxgs/io/gltf.h"
#include "io/gltf/gltf_builder.h"
#include "io/gltf/gltf_filter.h"
#include "io/gltf/gltf_plain.h"
#include "io/gltf/gltf_quantized.h"

namespace fluxgs {
namespace {

using namespace io;

Expected<std::vector<std::byte>> encode_floats(const SplatCloud& splats, const std::string& name) {
  GltfBuilder builder;
  const GltfMesh mesh{{{.attributes = add_plain_attributes(splats, builder),
                        .extras = screen_filter_extras(splats.filter)}}};
  auto file = allocate_glb(builder.document({mesh}, false), builder.bin_bytes(), name);
  if (!file) return std::unexpected(file.error());
  put_plain_attributes(splats, file->bytes.data() + file->bin);
  return std::move(file->bytes);
}

Expected<std::vector<std::byte>> encode_quantized(const SplatCloud& splats, int bits,
                                                  const std::string& name) {
  GltfBuilder builder;
  std::vector<GltfMesh> meshes;
  const std::vector<SizeClass> classes = size_classes(splats, bits);
  for (const SizeClass& one : classes)
    meshes.push_back({{{.attributes = add_quantized_attributes(splats, one, bits, builder),
                        .extras = screen_filter_extras(splats.filter)}},
                      one.scale});
  auto file = allocate_glb(builder.document(meshes, false), builder.bin_bytes(), name);
  if (!file) return std::unexpected(file.error());
  std::byte* at = file->bytes.data() + file->bin;
  for (const SizeClass& one : classes) at = put_quantized_attributes(splats, one, bits, at);
  return std::move(file->bytes);
}

}  // namespace

std::vector<std::uint32_t> glb_order(const SplatCloud& cloud, const GlbOptions& options) {
  std::vector<std::uint32_t> order;
  if (options.attribute_bits == 32) {
    order.resize(cloud.size());
    std::iota(order.begin(), order.end(), 0U);
    return order;
  }
  for (const SizeClass& one : size_classes(cloud, options.attribute_bits))
    order.insert(order.end(), one.splats.begin(), one.splats.end());
  return order;
}

Expected<std::vector<std::byte>> encode_glb(const SplatCloud& cloud, const GlbOptions& options,
                                            const std::string& name) {
  const int bits = options.attribute_bits;
  if (bits != 8 && bits != 16 && bits != 32)
    return fail(name, "attribute bits", fmt::format("are {}; expected 8, 16 or 32", bits));
  SplatCloud storage;
  const auto finite = writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  if ((*finite)->size() > 0)
    return bits == 32 ? encode_floats(**finite, name) : encode_quantized(**finite, bits, name);
  auto file = allocate_glb(empty_gltf_document(), 0, name);
  if (!file) return std::unexpected(file.error());
  return std::move(file->bytes);
}

Expected<std::vector<std::byte>> encode_glb(const SplatCloud& cloud, const std::string& name) {
  return encode_glb(cloud, GlbOptions{}, name);
}

}  // namespace fluxgs
