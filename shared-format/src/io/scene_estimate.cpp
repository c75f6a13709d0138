#include "fluxgs/io/scene_estimate.h"

#include <algorithm>

#include "fluxgs/io/scene.h"
#include "fluxgs/io/sog.h"
#include "io/gltf/gltf_document.h"
#include "io/ply/ply_header.h"
#include "io/splat/splat_record.h"
#include "io/spz/spz_packed.h"

namespace fluxgs {
namespace {

using namespace io;

struct Announced {
  std::uint64_t splats = 0;
  int sh_degree = 0;
};

int degree_of_rest(std::size_t numbers) {
  for (int degree = 3; degree > 0; --degree)
    if (numbers >= 3 * static_cast<std::size_t>(sh_rest_count(degree))) return degree;
  return 0;
}

Expected<Announced> in_ply(std::span<const std::byte> bytes, std::uint64_t size,
                           const std::string& name) {
  const auto header = parse_ply_header(bytes, size, name);
  if (!header) return std::unexpected(header.error());
  Announced result;
  std::size_t rest = 0;
  for (const PlyElement& element : header->elements) {
    if (element.name == "vertex") result.splats = element.count;
    if (element.name != "vertex" && element.name != "sh") continue;  // sh: of compressed ones
    rest += static_cast<std::size_t>(std::ranges::count_if(
        element.properties,
        [](const PlyProperty& property) { return property.name.starts_with("f_rest_"); }));
  }
  result.sh_degree = degree_of_rest(rest);
  return result;
}

Expected<Announced> in_gltf(std::span<const std::byte> bytes, const std::string& name) {
  const MemoryBytes source(bytes);
  const auto document = open_gltf(source, {}, name);
  if (!document) return std::unexpected(document.error());
  Announced result;
  for (const GltfInstance& instance : document->instances) {
    result.splats += instance.splats.count;
    result.sh_degree = std::max(result.sh_degree, instance.splats.sh_degree);
  }
  return result;
}

Expected<Announced> in_spz(std::span<const std::byte> bytes, const std::string& name) {
  const auto header = read_spz_header({bytes, name, ""});
  if (!header) return std::unexpected(header.error());
  return Announced{header->count, std::clamp(header->sh_degree, 0, 3)};
}

Expected<Announced> in_sog(std::span<const std::byte> bytes, const std::string& name) {
  const auto found = announced_by_sog(bytes, name);
  if (!found) return std::unexpected(found.error());
  return Announced{found->first, found->second};
}

Expected<Announced> announced(const std::string& format, std::span<const std::byte> bytes,
                              const std::string& name) {
  if (format == "ply" || format == "compressed.ply") return in_ply(bytes, bytes.size(), name);
  if (format == "glb" || format == "gltf") return in_gltf(bytes, name);
  if (format == "spz") return in_spz(bytes, name);
  if (format == "splat") return Announced{bytes.size() / sizeof(SplatRecord), 0};
  if (format == "sog") return in_sog(bytes, name);
  return Announced{};
}

SceneEstimate estimate_of(const std::string& format, const Announced& found) {
  constexpr std::uint64_t kMax = std::uint64_t{1} << 40;  // beyond, nobody has the memory
  return {.format = format,
          .splats = found.splats,
          .sh_degree = found.sh_degree,
          .decoded = splat_memory_bytes(std::min(found.splats, kMax), found.sh_degree)};
}

}  // namespace

Expected<SceneEstimate> estimate_scene(std::span<const std::byte> bytes, const std::string& name) {
  const auto format = recognise_scene(bytes, name);
  if (!format) return std::unexpected(format.error());
  const std::string format_name((*format)->name);
  const auto found = announced(format_name, bytes, name);
  if (!found) return std::unexpected(found.error());
  return estimate_of(format_name, *found);
}

std::optional<SceneEstimate> estimate_beginning(std::span<const std::byte> begin,
                                                std::uint64_t size, const std::string& name) {
  const auto format = recognise_beginning(begin, name);
  if (!format) return std::nullopt;
  const std::string format_name((*format)->name);
  const auto found = [&]() -> Expected<Announced> {
    if (format_name == "ply" || format_name == "compressed.ply") return in_ply(begin, size, name);
    if (format_name == "spz") return in_spz(begin, name);
    if (format_name == "splat" && size != kUnknownSize)
      return Announced{size / sizeof(SplatRecord), 0};
    return fail(name, "", "announces nothing at its beginning");
  }();
  return found ? std::optional(estimate_of(format_name, *found)) : std::nullopt;
}

}  // namespace fluxgs
