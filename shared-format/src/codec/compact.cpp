#include "codec/compact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "codec/channels.h"
#include "codec/importance.h"
#include "codec/morton.h"
#include "codec/positions.h"
#include "fluxgs/math/projection.h"
#include "io/activation.h"
#include "io/cloud_memory.h"

namespace fluxgs::codec {
namespace {

// What a picture cannot tell apart from 0 and 1: opacities below 1/255 are not drawn, those above
// 0.99 are cut there (render_options.h)
constexpr double kLeastOpacity = 1e-3, kMostOpacity = 1 - 1e-3;

/// The rotation with the largest |w| of the four that differ by half turns about the splat's own
/// axes, which leave its covariance as it is, with w > 0: x, y, z are then at most ½·√3 long, and w
/// follows from them.
glm::vec3 reduced_rotation(const glm::quat& rotation) {
  const auto q =
      math::normalized(math::Quat<double>{rotation.w, rotation.x, rotation.y, rotation.z});
  // q·1, q·i, q·j, q·k
  const std::array<std::array<double, 4>, 4> same{{{q.w, q.x, q.y, q.z},
                                                   {-q.x, q.w, q.z, -q.y},
                                                   {-q.y, -q.z, q.w, q.x},
                                                   {-q.z, q.y, -q.x, q.w}}};
  const auto& best = *std::ranges::max_element(
      same, {}, [](const std::array<double, 4>& r) { return std::abs(r[0]); });
  const double sign = best[0] < 0 ? -1 : 1;
  return {sign * best[1], sign * best[2], sign * best[3]};
}

glm::quat full_rotation(const float* v) {
  const glm::vec3 xyz(v[0], v[1], v[2]);
  const float square = xyz.x * xyz.x + xyz.y * xyz.y + xyz.z * xyz.z;
  if (square < 1) return glm::quat(std::sqrt(1 - square), xyz.x, xyz.y, xyz.z);
  return glm::normalize(glm::quat(0, xyz.x, xyz.y, xyz.z));
}

float opacity_logit(float scale) {
  const double root = std::sin(std::clamp(double{scale}, 0.0, 1.0) * std::numbers::pi / 2);
  const double opacity = std::clamp(root * root, kLeastOpacity, kMostOpacity);
  return io::logit(opacity);
}

// Splats that no picture shows keep a shape all the same
constexpr double kLeastWeight = 0.05, kMostWeight = 20;

// Each attribute may rest on those before it: their decoded values tell how exactly it is stored.
enum Attribute : std::size_t { kScale = 1, kOpacity, kRotation, kDc, kRest, kEnd };

std::size_t channels_of(Attribute attribute, int sh_degree) {
  if (attribute == kOpacity) return 1;
  return attribute == kRest ? 3 * static_cast<std::size_t>(sh_rest_count(sh_degree)) : 3;
}

std::vector<float> coarseness_of(Attribute attribute, const SplatCloud& decoded) {
  if (attribute == kRotation) return rotation_coarseness(decoded.log_scales);
  if (attribute == kDc || attribute == kRest)
    return color_coarseness(decoded.log_scales, decoded.opacity_logits);
  return {};
}

void put_vec3(std::vector<float>& out, const glm::vec3& v) {
  for (int c = 0; c < 3; ++c) out.push_back(v[c]);
}
glm::vec3 vec3_at(const float* v) { return {v[0], v[1], v[2]}; }

std::vector<float> values_of(Attribute attribute, const SplatCloud& cloud) {
  std::vector<float> out;
  out.reserve(cloud.size() * channels_of(attribute, cloud.sh_degree));
  if (attribute == kOpacity)
    for (const float logit : cloud.opacity_logits) out.push_back(opacity_scale(logit));
  else if (attribute == kRotation)
    for (const glm::quat& q : cloud.rotations) put_vec3(out, reduced_rotation(q));
  else
    for (const glm::vec3& v : attribute == kScale ? cloud.log_scales
                              : attribute == kDc  ? cloud.sh_dc
                                                  : cloud.sh_rest)
      put_vec3(out, v);
  return out;
}

void store(Attribute attribute, const std::vector<float>& values, SplatCloud& cloud) {
  const float* v = values.data();
  if (attribute == kOpacity)
    for (float& logit : cloud.opacity_logits) logit = opacity_logit(*v++);
  else if (attribute == kRotation)
    for (glm::quat& q : cloud.rotations) q = full_rotation(v), v += 3;
  else
    for (glm::vec3& to : attribute == kScale ? cloud.log_scales
                         : attribute == kDc  ? cloud.sh_dc
                                             : cloud.sh_rest)
      to = vec3_at(v), v += 3;
}

float step_of(Attribute attribute, const CompactSteps& steps) {
  const float by_attribute[] = {0,           steps.log_scale, steps.opacity, steps.rotation,
                                steps.sh_dc, steps.sh_rest};
  return by_attribute[attribute];
}

std::unexpected<Error> in_attribute(std::size_t attribute, const Error& error) {
  return fail("", kAttributeNames[attribute], error.message());
}

/// Of errors in steps: those of a coarse splat are larger. In the order of the file, 1 on the
/// average.
std::vector<float> rounding_weights(std::span<const float> weights,
                                    const std::vector<std::uint32_t>& order,
                                    const std::vector<float>& coarseness) {
  if (weights.empty()) return {};
  std::vector<float> result(order.size());
  double sum = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double c = coarseness.empty() ? 1.0 : double{coarseness[k]};
    sum += double{result[k] = static_cast<float>(double{weights[order[k]]} * c * c)};
  }
  if (!(sum > 0)) return {};
  const double mean = sum / static_cast<double>(order.size());
  for (float& weight : result)
    weight = static_cast<float>(std::clamp(double{weight} / mean, kLeastWeight, kMostWeight));
  return result;
}

Expected<std::span<const std::byte>> take_section(Reader& in, std::size_t attribute) {
  const auto size = in.take_varint();
  const auto bytes = size ? in.take_bytes(*size) : std::nullopt;
  if (!bytes) return fail("", kAttributeNames[attribute], "is cut off");
  return *bytes;
}

void put_section(Bytes& out, const Bytes& section) {
  put_varint(out, section.size());
  out.insert(out.end(), section.begin(), section.end());
}

/// Decodes a section into the cloud, in which the attributes before it are decoded already.
Expected<void> decode_section(Attribute attribute, std::span<const std::byte> section,
                              SplatCloud& cloud) {
  const std::size_t channels = channels_of(attribute, cloud.sh_degree);
  std::vector<float> values(channels * cloud.size());
  Reader in(section);
  if (auto ok = decode_channels(in, channels, coarseness_of(attribute, cloud), values); !ok)
    return in_attribute(attribute, ok.error());
  if (in.left() > 0) return fail("", kAttributeNames[attribute], "has bytes left over");
  store(attribute, values, cloud);
  return {};
}

bool is_stored(Attribute attribute, int sh_degree) { return channels_of(attribute, sh_degree) > 0; }

}  // namespace

float opacity_scale(float logit) {
  const double root = std::sqrt(double{io::sigmoid(logit)});
  return static_cast<float>(std::asin(root) * 2 / std::numbers::pi);
}

Expected<Bytes> encode_compact(const SplatCloud& cloud, const CompactOptions& options) {
  Bytes out, section;
  if (cloud.size() == 0) return out;
  const auto order = morton_order(cloud.positions);
  const SplatCloud ordered = in_order(cloud, order);
  const CompactSteps& steps = options.steps;
  if (auto ok = encode_positions(ordered.positions, steps.position, section); !ok)
    return std::unexpected(ok.error());
  put_section(out, section);
  SplatCloud decoded = ordered;
  for (std::size_t a = kScale; a < kEnd; ++a) {
    const auto attribute = static_cast<Attribute>(a);
    if (!is_stored(attribute, cloud.sh_degree)) continue;
    const Channels input{channels_of(attribute, cloud.sh_degree), values_of(attribute, ordered),
                         coarseness_of(attribute, decoded)};
    const auto weights = rounding_weights(options.weights, order, input.coarseness);
    section.clear();
    if (auto ok = encode_channels(input, step_of(attribute, steps), {options.rate_weight, weights},
                                  section);
        !ok)
      return in_attribute(a, ok.error());
    if (auto ok = decode_section(attribute, section, decoded); !ok)
      return std::unexpected(ok.error());
    put_section(out, section);
  }
  while (cloud.size() > most_splats(out.size())) out.push_back(std::byte{0});
  return out;
}

Expected<SplatCloud> decode_compact(std::span<const std::byte> bytes, std::size_t count,
                                    int sh_degree) {
  if (count > most_splats(bytes.size()))
    return fail("", "",
                fmt::format("{} splats in {} bytes, expected {} at most", count, bytes.size(),
                            most_splats(bytes.size())));
  auto cloud = io::allocate_cloud(count, sh_degree, "");
  if (!cloud || count == 0) return cloud;
  Reader in(bytes);
  const auto positions = take_section(in, 0);
  if (!positions) return std::unexpected(positions.error());
  Reader part(*positions);
  if (auto ok = decode_positions(part, cloud->positions); !ok) return std::unexpected(ok.error());
  for (std::size_t a = kScale; a < kEnd; ++a) {
    const auto attribute = static_cast<Attribute>(a);
    if (!is_stored(attribute, sh_degree)) continue;
    const auto section = take_section(in, a);
    if (!section) return std::unexpected(section.error());
    if (auto ok = decode_section(attribute, *section, *cloud); !ok)
      return std::unexpected(ok.error());
  }
  const auto padding = *in.take_bytes(in.left());
  if (std::ranges::any_of(padding, [](std::byte b) { return b != std::byte{0}; }))
    return fail("", "", "bytes other than zeros are left over behind the last attribute");
  return cloud;
}

Expected<std::vector<std::size_t>> attribute_bytes(std::span<const std::byte> bytes) {
  Reader in(bytes);
  std::vector<std::size_t> sizes;
  while (in.left() > 0 && sizes.size() < std::size(kAttributeNames)) {
    const auto section = take_section(in, sizes.size());
    if (!section) return std::unexpected(section.error());
    sizes.push_back(section->size());
  }
  return sizes;
}

}  // namespace fluxgs::codec
