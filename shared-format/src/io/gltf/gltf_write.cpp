#include "cloud/cloud_memory.h"
#include "fluxgs/io/gltf.h"
#include "io/gltf/gltf_builder.h"
#include "io/gltf/gltf_filter.h"
#include "io/gltf/gltf_plain.h"

namespace fluxgs {

Expected<std::vector<std::byte>> encode_glb(const SplatCloud& cloud, const std::string& name) {
  SplatCloud storage;
  const auto finite = io::writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  const SplatCloud& splats = **finite;
  io::GltfBuilder builder;
  nlohmann::json document = io::empty_gltf_document();
  if (splats.size() > 0)
    document = builder.document({{.attributes = io::add_plain_attributes(splats, builder),
                                  .extras = io::screen_filter_extras(splats.filter)}},
                                false);
  auto file = io::allocate_glb(document, builder.bin_bytes(), name);
  if (!file) return std::unexpected(file.error());
  if (splats.size() > 0) io::put_plain_attributes(splats, file->bytes.data() + file->bin);
  return std::move(file->bytes);
}

}  // namespace fluxgs
