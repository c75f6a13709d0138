#include "fluxgs/io/compact_glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "cloud/cloud_memory.h"
#include "cloud/degree_buckets.h"
#include "cloud/gather.h"
#include "cloud/importance_chunks.h"
#include "codec/compact.h"
#include "codec/positions.h"
#include "codec/step_means.h"
#include "fluxgs/io/gltf_frame.h"
#include "io/gltf/gltf_builder.h"
#include "io/gltf/gltf_compact.h"
#include "io/gltf/gltf_filter.h"
#include "io/gltf/gltf_json.h"
#include "io/gltf/gltf_plain.h"
#include "io/splat/scene_core.h"

namespace fluxgs {
namespace {

using nlohmann::json;

// Measured on scans and on scenes trained from images: at these ratios a bit more for any attribute
// buys about the same error.
constexpr double kPositionPerSize = 0.36;
constexpr QuantizationSteps kDefault{.position = 0,
                                     .log_scale = 0.4f,
                                     .rotation = 0.085f,
                                     .opacity = 0.045f,
                                     .sh_dc = 0.26f,
                                     .sh_rest = 0.18f};

/// The usual standard deviation of a splat.
double median_size(const SplatCloud& cloud) {
  return std::exp(std::clamp(io::median_log_size(cloud), -60.0, 60.0));  // beyond are no lengths
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

/// The order of a bucket's splats: that of their positions in glTF's frame.
std::vector<std::uint32_t> order_within(const io::DegreeBucket& bucket, const SplatCloud& cloud,
                                        double step) {
  std::vector<glm::vec3> turned;
  turned.reserve(bucket.splats.size());
  for (const std::uint32_t i : bucket.splats)
    turned.push_back(io::turn_position(cloud.positions[i]));
  std::vector<std::uint32_t> order = codec::position_order(turned, step);
  for (std::uint32_t& k : order) k = bucket.splats[k];
  return order;
}

/// Basis functions of odd orders change their signs between the frames, as x and y do, and with
/// them their rows and columns of lower triangles.
template <class Sign>
void turn_matrices(std::vector<float>& matrices, int rows, const Sign& sign) {
  for (std::size_t at = 0; at < matrices.size();)
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column <= row; ++column) matrices[at++] *= sign(row) * sign(column);
}

void turn_sensitivity(SensitivityWeights& sensitivity, int sh_degree) {
  turn_matrices(sensitivity.sh_factors, sh_rest_count(sh_degree) + 1, [](int function) {
    return function == 0 ? 1.0f : io::turn_sign(static_cast<std::size_t>(function - 1));
  });
  const glm::vec3 axes = io::turn_position(glm::vec3(1));
  turn_matrices(sensitivity.rotation, 3, [&](int axis) { return axes[axis]; });
}

std::vector<std::uint32_t> finite_splats(const SplatCloud& cloud) {
  std::vector<std::uint32_t> splats;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (is_finite(cloud, i)) splats.push_back(static_cast<std::uint32_t>(i));
  return splats;
}

Expected<void> check_networks(const CompactNetworks& networks, const SplatCloud& cloud,
                              const std::string& name) {
  const bool has_psi = !networks.models.psi.empty();
  if (!has_psi && networks.models.phi.empty())
    return fail(name, "networks", "there are none, expected one at least");
  if (cloud.sh_degree != 1)
    return fail(name, "networks",
                fmt::format("the scene has degree {}, expected 1", cloud.sh_degree));
  static_assert(codec::kEnergyChannels == networks::kEnergyColumns);
  const std::size_t expected = has_psi ? codec::kEnergyChannels * cloud.size() : 0;
  if (networks.energy.size() != expected)
    return fail(name, "energy",
                fmt::format("{} values, expected {}", networks.energy.size(), expected));
  if (!std::ranges::all_of(networks.energy, [](float v) { return std::isfinite(v); }))
    return fail(name, "energy", "has a value that is not finite");
  return {};
}

Expected<void> check_options(const CompactOptions& options, const SplatCloud& cloud,
                             const std::string& name) {
  const SensitivityWeights& sensitivity = options.sensitivity;
  if (auto ok = check_sensitivity(sensitivity, cloud, name); !ok || !options.networks) return ok;
  if (!sensitivity.sh_factors.empty() || !sensitivity.scale.empty() ||
      !sensitivity.rotation.empty())
    return fail(name, "costs", "of scenes with networks are weights, expected nothing else");
  return check_networks(*options.networks, cloud, name);
}

/// A stream as it is read. `source`: what it was made of.
Expected<SplatCloud> decode(const std::vector<std::byte>& stream, const SplatCloud& source,
                            const std::optional<CompactNetworks>& networks,
                            const std::string& name) {
  io::GltfSplats splats;
  splats.count = source.size();
  splats.sh_degree = source.sh_degree;
  splats.compression = io::GltfCompression::compact;
  splats.compressed_field = io::kCompactExtension;
  io::CompactBytes bytes{.stream = stream, .psi = {}, .phi = {}};
  if (networks) {
    bytes.psi = networks->models.psi;
    bytes.phi = networks->models.phi;
    splats.networks = io::GltfNetworks{
        {0, 0, bytes.psi.size()}, {0, 0, bytes.phi.size()}, networks->normalisation};
  }
  auto cloud = io::decode_compact_splats(splats, bytes, name);
  if (cloud) io::turn_cloud(*cloud);
  return cloud;
}

json networks_json(const CompactNetworks& networks, io::GltfBuilder& builder) {
  const networks::Normalisation& n = networks.normalisation;
  json result = {{"normalisation",
                  {{"center", {n.center.x, n.center.y, n.center.z}},
                   {"extent", n.extent},
                   {"logScaleMean", n.log_scale_mean},
                   {"logScaleDeviation", n.log_scale_deviation},
                   {"shMean", n.sh_mean},
                   {"shDeviation", n.sh_deviation}}}};
  for (const auto& [key, model] :
       {std::pair("psi", &networks.models.psi), std::pair("phi", &networks.models.phi)})
    if (!model->empty()) result[key] = {{"bufferView", builder.add_view(model->size(), false)}};
  return result;
}

/// The parts of the BIN chunk in the order in which they were announced.
class BinWriter {
 public:
  explicit BinWriter(std::byte* at) : at_(at) {}

  void put(const std::vector<std::byte>& bytes) {
    if (!bytes.empty()) std::memcpy(at_, bytes.data(), bytes.size());
    at_ += (bytes.size() + 3) / 4 * 4;
  }
  void put_plain_attributes(const SplatCloud& splats) {
    at_ = io::put_plain_attributes(splats, at_);
  }

 private:
  std::byte* at_;
};

constexpr std::size_t kFewestOfAShare = 6'000;

/// Splats that have a stream of their own.
struct Share {
  std::size_t chunk = 0;
  io::DegreeBucket splats;
};

/// In each chunk a share for each degree that there is. Networks know scenes of degree 1 and make
/// what is in their bands.
std::vector<Share> shares_of(const SplatCloud& cloud, const std::vector<io::SplatChunk>& chunks,
                             bool has_networks) {
  std::vector<Share> shares;
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    if (has_networks)
      shares.push_back({c, {cloud.sh_degree, chunks[c]}});
    else
      for (io::DegreeBucket& bucket : io::degree_buckets(cloud, chunks[c]))
        shares.push_back({c, std::move(bucket)});
  }
  return shares;
}

/// The shares of a scene, in chunks where those are large: JSON and tables of a share take about
/// two kilobytes.
std::vector<Share> shares_of(const SplatCloud& cloud, const CompactOptions& options) {
  const bool has_networks = options.networks.has_value();
  if (options.in_chunks && cloud.size() >= kFewestOfAShare) {
    auto shares = shares_of(cloud, io::importance_chunks(cloud), has_networks);
    if (cloud.size() >= kFewestOfAShare * shares.size()) return shares;
  }
  return shares_of(cloud, {io::one_chunk(cloud)}, has_networks);
}

/// A primitive as it is stored and as it is read.
struct Part {
  std::size_t chunk = 0;
  std::vector<std::byte> stream;
  SplatCloud decoded;
};

/// Steps and costs of a scene, and what those of its parts are relative to.
struct Quantization {
  const CompactOptions& options;
  codec::StepMeans means;
  codec::RateWeights weights;
};

Expected<Part> make_part(const SplatCloud& scene, const Share& share, const Quantization& of_scene,
                         const std::string& name) {
  const auto& [sh_degree, indices] = share.splats;
  const SplatCloud splats = io::cloud_of(share.splats, scene);
  CompactOptions own{.rate_weight = of_scene.options.rate_weight};
  own.steps =
      codec::steps_within(of_scene.options.steps, codec::step_means(splats), of_scene.means);
  own.sensitivity =
      sensitivity_of(of_scene.options.sensitivity, scene.sh_degree, indices, sh_degree);
  const std::optional<CompactNetworks>& networks = of_scene.options.networks;
  const std::vector<float> energy =
      io::gather(networks ? networks->energy : std::vector<float>(), indices,
                 codec::kEnergyChannels, codec::kEnergyChannels);
  auto stream = codec::encode_compact(splats, own, energy, of_scene.weights.of(indices));
  if (!stream) return fail(name, stream.error().field, stream.error().what);
  auto decoded = decode(*stream, splats, networks, name);
  if (!decoded) return std::unexpected(decoded.error());
  return Part{share.chunk, std::move(*stream), std::move(*decoded)};
}

/// All with the same quantization.
Expected<std::vector<Part>> make_parts(const SplatCloud& splats, const CompactOptions& options,
                                       const std::string& name) {
  const Quantization quantization{options, codec::step_means(splats),
                                  codec::RateWeights(splats, options.sensitivity)};
  std::vector<Part> parts;
  for (const Share& share : shares_of(splats, options)) {
    auto part = make_part(splats, share, quantization, name);
    if (!part) return std::unexpected(part.error());
    parts.push_back(std::move(*part));
  }
  return parts;
}

io::GltfPrimitive describe(const Part& part, const json& networks, const ScreenFilter& filter,
                           bool plain_attributes, io::GltfBuilder& builder) {
  json extension = {{"version", io::kCompactVersion},
                    {"bufferView", builder.add_view(part.stream.size(), false)}};
  if (part.chunk > 0) extension["chunk"] = part.chunk;
  if (!networks.is_null()) extension["networks"] = networks;
  json attributes = plain_attributes ? io::add_plain_attributes(part.decoded, builder)
                                     : add_described_attributes(part.decoded, builder);
  return {std::move(attributes),
          {{io::kCompactExtension, std::move(extension)}},
          io::screen_filter_extras(filter)};
}

/// The file of all parts: the networks that all chunks need lie first, then the chunks.
Expected<std::vector<std::byte>> make_file(const std::vector<Part>& parts,
                                           const CompactOptions& options,
                                           const ScreenFilter& filter, const std::string& name) {
  io::GltfBuilder builder;
  const json networks = options.networks ? networks_json(*options.networks, builder) : json();
  std::vector<io::GltfPrimitive> primitives;
  for (const Part& part : parts)
    primitives.push_back(describe(part, networks, filter, options.plain_attributes, builder));
  auto file =
      io::allocate_glb(builder.document({{std::move(primitives)}}, !options.plain_attributes),
                       builder.bin_bytes(), name);
  if (!file) return std::unexpected(file.error());
  BinWriter bin(file->bytes.data() + file->bin);
  if (options.networks) {
    bin.put(options.networks->models.psi);
    bin.put(options.networks->models.phi);
  }
  for (const Part& part : parts) {
    bin.put(part.stream);
    if (options.plain_attributes) bin.put_plain_attributes(part.decoded);
  }
  return std::move(file->bytes);
}

constexpr double kFinestPart = 0x1p-23;  // of the extent: the finest step

}  // namespace

double finest_position_step(const SplatCloud& cloud) {
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud, i)) continue;  // is not written
    low = glm::min(low, glm::dvec3(cloud.positions[i]));
    high = glm::max(high, glm::dvec3(cloud.positions[i]));
  }
  const glm::dvec3 extent = high - low;
  return std::max(std::max({extent.x, extent.y, extent.z}) * kFinestPart, 1e-30);
}

double largest_fine_extent(const SplatCloud& cloud, double step_scale) {
  return kPositionPerSize * median_size(cloud) * step_scale / kFinestPart;
}

QuantizationSteps default_quantization_steps(const SplatCloud& cloud, double step_scale) {
  QuantizationSteps steps = kDefault;
  steps.position = kPositionPerSize * median_size(cloud);
  steps = scaled(steps, step_scale);
  steps.position = std::max(steps.position, finest_position_step(cloud));
  return steps;
}

QuantizationSteps scaled(const QuantizationSteps& steps, double factor) {
  QuantizationSteps result = steps;
  result.position *= factor;
  for (float* step : {&result.log_scale, &result.rotation, &result.opacity, &result.sh_dc,
                      &result.sh_rest, &result.energy})
    *step = static_cast<float>(double{*step} * factor);
  return result;
}

glm::quat canonical_rotation(const glm::quat& rotation) {
  return io::turn_from_gltf(codec::canonical_rotation(io::turn_to_gltf(rotation)));
}

void canonicalize_rotations(SplatCloud& cloud) {
  for (glm::quat& q : cloud.rotations) q = canonical_rotation(q);
}

std::vector<std::uint32_t> compact_order(const SplatCloud& cloud, const CompactOptions& options) {
  std::vector<std::uint32_t> order;
  for (const Share& share : shares_of(cloud, options))
    std::ranges::copy(order_within(share.splats, cloud, options.steps.position),
                      std::back_inserter(order));
  return order;
}

Expected<std::vector<std::byte>> encode_compact_glb(const SplatCloud& cloud,
                                                    const CompactOptions& options,
                                                    const std::string& name) {
  SplatCloud splats;
  const auto finite = io::writable_cloud(cloud, splats, name);
  if (!finite) return std::unexpected(finite.error());
  if (auto ok = check_options(options, cloud, name); !ok) return std::unexpected(ok.error());
  CompactOptions own = options;
  const std::vector<std::uint32_t> kept = finite_splats(cloud);
  own.sensitivity = sensitivity_of(options.sensitivity, cloud.sh_degree, kept, cloud.sh_degree);
  turn_sensitivity(own.sensitivity, cloud.sh_degree);
  if (own.networks)
    own.networks->energy =
        io::gather(own.networks->energy, kept, codec::kEnergyChannels, codec::kEnergyChannels);
  if (*finite == &cloud) splats = cloud;
  if (splats.size() == 0) {
    auto file = io::allocate_glb(io::empty_gltf_document(), 0, name);
    if (!file) return std::unexpected(file.error());
    return std::move(file->bytes);
  }
  io::turn_cloud(splats);
  const auto parts = make_parts(splats, own, name);
  if (!parts) return std::unexpected(parts.error());
  return make_file(*parts, own, cloud.filter, name);
}

}  // namespace fluxgs
