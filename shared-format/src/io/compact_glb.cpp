#include "fluxgs/io/compact_glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "cloud_memory.h"
#include "codec/compact.h"
#include "codec/morton.h"
#include "gltf_builder.h"
#include "gltf_frame.h"
#include "gltf_json.h"
#include "gltf_plain.h"

namespace fluxgs {
namespace {

using nlohmann::json;

// Measured on scans and on scenes trained from photos: at these ratios a bit more for any attribute
// buys about the same error.
constexpr double kPositionPerSize = 0.35;
constexpr CompactSteps kUsual{.position = 0,
                              .log_scale = 0.2f,
                              .rotation = 0.05f,
                              .opacity = 0.035f,
                              .sh_dc = 0.15f,
                              .sh_rest = 0.15f};

/// The median over the splats of the geometric mean of their standard deviations.
double median_size(const SplatCloud& cloud) {
  std::vector<float> sizes;
  sizes.reserve(cloud.size());
  for (const glm::vec3& s : cloud.log_scales)
    if (const float mean = (s.x + s.y + s.z) / 3; std::isfinite(mean)) sizes.push_back(mean);
  if (sizes.empty()) return 1;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  return std::exp(double{*middle});
}

/// A step so fine that coordinates would take more than 24 bits says nothing that floats can hold.
double finest_step(const SplatCloud& cloud) {
  glm::vec3 most(0);
  for (const glm::vec3& p : cloud.positions)
    if (std::isfinite(p.x + p.y + p.z)) most = glm::max(most, glm::abs(p));
  return std::max(double{std::max({most.x, most.y, most.z})} * 0x1p-24, 1e-30);
}

/// Accessors without data, which share what is alike.
json add_described_attributes(const SplatCloud& cloud, io::GltfBuilder& builder) {
  json named = json::object(), by_type = json::object();
  for (const auto& [semantic, type] : io::splat_semantics(cloud.sh_degree)) {
    json accessor = {{"componentType", io::kGltfFloat}, {"count", cloud.size()}, {"type", type}};
    if (named.empty()) {
      auto [low, high] = io::gltf_bounds(cloud);
      accessor["min"] = std::move(low);
      accessor["max"] = std::move(high);
      named[semantic] = builder.add_accessor(std::move(accessor));
      continue;
    }
    if (!by_type.contains(type)) by_type[type] = builder.add_accessor(std::move(accessor));
    named[semantic] = by_type[type];
  }
  return named;
}

std::vector<float> weights_of_finite(const std::vector<float>& weights, const SplatCloud& cloud) {
  std::vector<float> kept;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (is_finite(cloud, i)) kept.push_back(weights[i]);
  return kept;
}

}  // namespace

CompactSteps usual_compact_steps(const SplatCloud& cloud, double coarseness) {
  CompactSteps steps = kUsual;
  steps.position = kPositionPerSize * median_size(cloud);
  steps = scaled(steps, coarseness);
  steps.position = std::max(steps.position, finest_step(cloud));
  return steps;
}

CompactSteps scaled(const CompactSteps& steps, double factor) {
  CompactSteps result = steps;
  result.position *= factor;
  for (float* step :
       {&result.log_scale, &result.rotation, &result.opacity, &result.sh_dc, &result.sh_rest})
    *step = static_cast<float>(double{*step} * factor);
  return result;
}

std::vector<std::uint32_t> compact_order(const SplatCloud& cloud) {
  std::vector<glm::vec3> turned;
  turned.reserve(cloud.size());
  for (const glm::vec3& p : cloud.positions) turned.push_back(io::turn_position(p));
  return codec::morton_order(turned);
}

Expected<std::vector<std::byte>> encode_compact_glb(const SplatCloud& cloud,
                                                    const CompactOptions& options,
                                                    const std::string& name) {
  SplatCloud splats;
  const auto finite = io::writable_cloud(cloud, splats, name);
  if (!finite) return std::unexpected(finite.error());
  if (!options.weights.empty() && options.weights.size() != cloud.size())
    return fail(name, "weights",
                fmt::format("{} of them, expected one for each of {} splats",
                            options.weights.size(), cloud.size()));
  CompactOptions own = options;
  own.weights = weights_of_finite(options.weights, cloud);
  if (*finite == &cloud) splats = cloud;
  if (splats.size() == 0) {
    auto file = io::allocate_glb(io::empty_gltf_document(), 0, name);
    if (!file) return std::unexpected(file.error());
    return std::move(file->bytes);
  }
  io::turn_cloud(splats);
  const auto data = codec::encode_compact(splats, own);
  if (!data) return fail(name, data.error().field, data.error().what);
  // What comes out of the file: for its bounds, its plain attributes, and as a check
  auto decoded = codec::decode_compact(*data, splats.size(), splats.sh_degree);
  if (!decoded) return fail(name, decoded.error().field, decoded.error().what);
  io::turn_cloud(*decoded);

  io::GltfBuilder builder;
  const std::size_t view = builder.add_view(data->size(), false);
  const std::size_t plain = builder.bin_bytes();
  json attributes = options.plain_attributes ? io::add_plain_attributes(*decoded, builder)
                                             : add_described_attributes(*decoded, builder);
  const json nested = {
      {io::kCompactExtension, {{"version", io::kCompactVersion}, {"bufferView", view}}}};
  auto file =
      io::allocate_glb(builder.document(std::move(attributes), nested, !options.plain_attributes),
                       builder.bin_bytes(), name);
  if (!file) return std::unexpected(file.error());
  std::byte* bin = file->bytes.data() + file->bin;
  std::memcpy(bin, data->data(), data->size());
  if (options.plain_attributes) io::put_plain_attributes(*decoded, bin + plain);
  return std::move(file->bytes);
}

}  // namespace fluxgs
