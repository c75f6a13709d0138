#include "io/gltf/gltf_spz.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "fluxgs/io/gltf_frame.h"
#include "io/gltf/gltf_json.h"

namespace fluxgs::io {

Expected<GltfSplats> find_spz_splats(const GltfCompressedPlace& place, int view,
                                     const std::string& extension) {
  auto splats = describe_compressed(place, view, extension.c_str());
  if (!splats) return splats;
  splats->compression = GltfCompression::spz;
  std::vector<std::byte> room;
  const auto bytes = place.buffers.read(splats->compressed, room);
  if (!bytes) return std::unexpected(bytes.error());
  const SpzSource source{*bytes, place.name, splats->compressed_field};
  const auto header = read_spz_header(source);
  if (!header) return std::unexpected(header.error());
  if (header->count != splats->count) {
    return source.fail(
        "header", fmt::format("has {} splats, but POSITION has {}", header->count, splats->count));
  }
  // The first draft named its harmonics COLOR_1 to COLOR_15, and writers leave them out.
  if (splats->sh_degree == 0) splats->sh_degree = header->sh_degree;
  if (header->sh_degree != splats->sh_degree) {
    return source.fail("header", fmt::format("has degree {}, but the attributes have {}",
                                             header->sh_degree, splats->sh_degree));
  }
  return splats;
}

glm::vec3 spz_signs_in_gltf(const SpzPacked& packed, const std::optional<GltfBounds>& bounds) {
  const glm::vec3 converted = turn_position(packed.axes.value_or(kRightUpBack)), stored(1);
  if (!bounds || packed.header.count == 0) return converted;
  const AxisFlip flip = make_axis_flip(stored);
  SplatValues splat{};
  glm::dvec3 least(std::numeric_limits<double>::max()), most(-least);
  for (std::size_t i = 0; i < packed.header.count; ++i) {
    read_spz_splat(packed, i, flip, splat);
    least = glm::min(least, glm::dvec3(splat.position));
    most = glm::max(most, glm::dvec3(splat.position));
  }
  const auto misfit = [&](const glm::vec3& signs) {
    const glm::dvec3 a = least * glm::dvec3(signs), b = most * glm::dvec3(signs);
    const glm::dvec3 off =
        glm::abs(glm::min(a, b) - bounds->least) + glm::abs(glm::max(a, b) - bounds->most);
    return off.x + off.y + off.z;
  };
  return misfit(stored) < misfit(converted) ? stored : converted;
}

}  // namespace fluxgs::io
