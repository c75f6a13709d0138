#include "io/gltf/gltf_compressed.h"

#include <optional>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "fluxgs/sanitize.h"
#include "io/gltf/gltf_accessor.h"

namespace fluxgs::io {
namespace {

// The count that all attributes share. Their accessors need no data of their own.
Expected<std::size_t> shared_count(const tinygltf::Model& model,
                                   const tinygltf::Primitive& primitive, const std::string& name,
                                   const std::string& field) {
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) {
    return fail(name, field, "attribute POSITION is missing");
  }
  std::optional<std::size_t> count;
  const auto check = [&](const std::string& semantic, int accessor) -> Expected<void> {
    const auto index = static_cast<std::size_t>(accessor);
    const std::string where =
        fmt::format("{}: {}: accessor {}", field, sanitized(semantic), accessor);
    if (index >= model.accessors.size()) return fail(name, where, "does not exist");
    const std::size_t own = model.accessors[index].count;
    if (!count) count = own;
    if (own == *count) return {};
    return fail(name, where, fmt::format("has {} elements, but POSITION has {}", own, *count));
  };
  if (auto ok = check(position->first, position->second); !ok) return std::unexpected(ok.error());
  for (const auto& [semantic, accessor] : primitive.attributes) {
    if (auto ok = check(semantic, accessor); !ok) return std::unexpected(ok.error());
  }
  return *count;
}

// A degree that is begun must be complete, and so must all below it.
Expected<int> complete_degree(const tinygltf::Primitive& primitive, const std::string& name,
                              const std::string& field) {
  const int highest = highest_degree(primitive);
  for (int degree = 1; degree <= highest; ++degree) {
    for (int i = 0; i <= 2 * degree; ++i) {
      const std::string semantic =
          fmt::format("KHR_gaussian_splatting:SH_DEGREE_{}_COEF_{}", degree, i);
      if (primitive.attributes.contains(semantic)) continue;
      return fail(name, field, fmt::format("attribute {} is missing", semantic));
    }
  }
  return highest;
}

std::optional<GltfBounds> position_bounds(const tinygltf::Model& model,
                                          const tinygltf::Primitive& primitive) {
  const auto index = static_cast<std::size_t>(primitive.attributes.at("POSITION"));
  const std::vector<double>& least = model.accessors[index].minValues;
  const std::vector<double>& most = model.accessors[index].maxValues;
  if (least.size() != 3 || most.size() != 3) return std::nullopt;
  return GltfBounds{{least[0], least[1], least[2]}, {most[0], most[1], most[2]}};
}

}  // namespace

int highest_degree(const tinygltf::Primitive& primitive) {
  int highest = 0;
  for (int degree = 1; degree <= 3; ++degree) {
    const std::string prefix = fmt::format("KHR_gaussian_splatting:SH_DEGREE_{}_COEF_", degree);
    const auto found = primitive.attributes.lower_bound(prefix);
    if (found != primitive.attributes.end() && found->first.starts_with(prefix)) highest = degree;
  }
  return highest;
}

Expected<GltfSplats> describe_compressed(const GltfCompressedPlace& place, int view,
                                         const char* extension) {
  const auto count = shared_count(place.model, place.primitive, place.name, place.field);
  if (!count) return std::unexpected(count.error());
  const auto degree = complete_degree(place.primitive, place.name, place.field);
  if (!degree) return std::unexpected(degree.error());
  const auto found = find_view(place.model, view, place.buffers, place.name);
  if (!found) return std::unexpected(found.error());
  GltfSplats splats;
  splats.count = *count;
  splats.sh_degree = *degree;
  splats.compressed = *found;
  splats.compressed_field = fmt::format("{}: {}", place.field, extension);
  splats.bounds = position_bounds(place.model, place.primitive);
  return splats;
}

}  // namespace fluxgs::io
