#include "codec/compact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "codec/channels.h"
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

Channels channels_of(std::size_t channels, std::size_t splats) {
  return {channels, std::vector<float>(channels * splats)};
}

/// The attributes besides positions, in the order of kAttributeNames.
std::vector<Channels> attributes_of(const SplatCloud& cloud,
                                    const std::vector<std::uint32_t>& order) {
  const std::size_t n = order.size();
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  std::vector<Channels> all{channels_of(3, n), channels_of(3, n), channels_of(1, n),
                            channels_of(3, n)};
  if (rest > 0) all.push_back(channels_of(3 * rest, n));
  const auto put3 = [](Channels& to, std::size_t at, const glm::vec3& v) {
    for (int c = 0; c < 3; ++c) to.values[at + static_cast<std::size_t>(c)] = v[c];
  };
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = order[k];
    put3(all[0], 3 * k, cloud.log_scales[i]);
    put3(all[1], 3 * k, reduced_rotation(cloud.rotations[i]));
    all[2].values[k] = opacity_scale(cloud.opacity_logits[i]);
    put3(all[3], 3 * k, cloud.sh_dc[i]);
    for (std::size_t s = 0; s < rest; ++s)
      put3(all[4], 3 * (rest * k + s), cloud.sh_rest[rest * i + s]);
  }
  return all;
}

std::unexpected<Error> in_attribute(std::size_t attribute, const Error& error) {
  const std::string inner = error.message();
  return fail("", kAttributeNames[attribute], inner);
}

Expected<std::span<const std::byte>> take_section(Reader& in, std::size_t attribute) {
  const auto size = in.take_varint();
  const auto bytes = size ? in.take_bytes(*size) : std::nullopt;
  if (!bytes) return fail("", kAttributeNames[attribute], "is cut off");
  return *bytes;
}

/// Reads one section of `channels` numbers a splat and hands each splat's numbers to `set`.
template <class Set>
Expected<void> decode_section(Reader& in, std::size_t attribute, std::size_t channels,
                              std::vector<float>& values, std::size_t count, const Set& set) {
  const auto section = take_section(in, attribute);
  if (!section) return std::unexpected(section.error());
  values.resize(count * channels);
  Reader part(*section);
  if (auto ok = decode_channels(part, channels, values); !ok)
    return in_attribute(attribute, ok.error());
  if (part.left() > 0) return fail("", kAttributeNames[attribute], "has bytes left over");
  for (std::size_t i = 0; i < count; ++i) set(i, &values[i * channels]);
  return {};
}

glm::vec3 vec3_at(const float* v) { return {v[0], v[1], v[2]}; }

Expected<void> decode_attributes(Reader& in, SplatCloud& cloud) {
  const std::size_t n = cloud.size();
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  std::vector<float> values;
  const auto section = [&](std::size_t attribute, std::size_t channels, const auto& set) {
    return decode_section(in, attribute, channels, values, n, set);
  };
  if (auto ok =
          section(1, 3, [&](std::size_t i, const float* v) { cloud.log_scales[i] = vec3_at(v); });
      !ok)
    return ok;
  if (auto ok = section(
          2, 3, [&](std::size_t i, const float* v) { cloud.rotations[i] = full_rotation(v); });
      !ok)
    return ok;
  if (auto ok = section(
          3, 1,
          [&](std::size_t i, const float* v) { cloud.opacity_logits[i] = opacity_logit(*v); });
      !ok)
    return ok;
  if (auto ok = section(4, 3, [&](std::size_t i, const float* v) { cloud.sh_dc[i] = vec3_at(v); });
      !ok)
    return ok;
  if (rest == 0) return {};
  return section(5, 3 * rest, [&](std::size_t i, const float* v) {
    for (std::size_t s = 0; s < rest; ++s) cloud.sh_rest[rest * i + s] = vec3_at(v + 3 * s);
  });
}

void put_section(Bytes& out, const Bytes& section) {
  put_varint(out, section.size());
  out.insert(out.end(), section.begin(), section.end());
}

}  // namespace

float opacity_scale(float logit) {
  const double root = std::sqrt(double{io::sigmoid(logit)});
  return static_cast<float>(std::asin(root) * 2 / std::numbers::pi);
}

Expected<Bytes> encode_compact(const SplatCloud& cloud, const CompactSteps& steps) {
  Bytes out;
  if (cloud.size() == 0) return out;
  const std::vector<std::uint32_t> order = morton_order(cloud.positions);
  std::vector<glm::vec3> positions;
  positions.reserve(order.size());
  for (const std::uint32_t i : order) positions.push_back(cloud.positions[i]);
  Bytes section;
  if (auto ok = encode_positions(positions, steps.position, section); !ok)
    return std::unexpected(ok.error());
  put_section(out, section);
  const std::array by_attribute{steps.log_scale, steps.rotation, steps.opacity, steps.sh_dc,
                                steps.sh_rest};
  const std::vector<Channels> attributes = attributes_of(cloud, order);
  for (std::size_t a = 0; a < attributes.size(); ++a) {
    section.clear();
    if (auto ok = encode_channels(attributes[a], by_attribute[a], section); !ok)
      return in_attribute(a + 1, ok.error());
    put_section(out, section);
  }
  return out;
}

Expected<SplatCloud> decode_compact(std::span<const std::byte> bytes, std::size_t count,
                                    int sh_degree) {
  auto cloud = io::allocate_cloud(count, sh_degree, "");
  if (!cloud || count == 0) return cloud;
  Reader in(bytes);
  const auto section = take_section(in, 0);
  if (!section) return std::unexpected(section.error());
  Reader part(*section);
  if (auto ok = decode_positions(part, cloud->positions); !ok) return std::unexpected(ok.error());
  if (auto ok = decode_attributes(in, *cloud); !ok) return std::unexpected(ok.error());
  if (in.left() > 0) return fail("", "", "bytes are left over behind the last attribute");
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
