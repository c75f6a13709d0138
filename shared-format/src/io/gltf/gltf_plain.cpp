#include "io/gltf/gltf_plain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "cloud/activation.h"
#include "fluxgs/io/gltf_frame.h"
#include "fluxgs/math/projection.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

std::size_t floats_of(std::string_view type) {
  return type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
}

// COLOR_0 is linear, the colours of the splats are sRGB-encoded (the extension's note on fallback
// behaviour; IEC 61966-2-1).
std::uint8_t linear_colour(float dc) {
  const double c = std::clamp(colour_of(dc), 0.0, 1.0);
  return byte_of(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

glm::quat unit(const glm::quat& q) {
  const math::Quat<double> n = math::normalized(math::Quat<double>{q.w, q.x, q.y, q.z});
  return glm::quat(glm::dquat(n.w, n.x, n.y, n.z));
}

// Appends plain values to a buffer that is large enough.
struct Output {
  std::byte* at;

  template <class T>
  void put(const T& value) {
    std::memcpy(at, &value, sizeof value);
    at += sizeof value;
  }
  void put_vec3(const glm::vec3& v) {
    for (int c = 0; c < 3; ++c) put(v[c]);
  }
};

}  // namespace

std::array<std::uint8_t, 4> fallback_colour(const glm::vec3& sh_dc, float opacity_logit) {
  return {linear_colour(sh_dc.x), linear_colour(sh_dc.y), linear_colour(sh_dc.z),
          byte_of(opacity_of(opacity_logit))};
}

std::vector<std::pair<std::string, const char*>> splat_semantics(int sh_degree) {
  std::vector<std::pair<std::string, const char*>> list{
      {"POSITION", "VEC3"},
      {"KHR_gaussian_splatting:ROTATION", "VEC4"},
      {"KHR_gaussian_splatting:SCALE", "VEC3"},
      {"KHR_gaussian_splatting:OPACITY", "SCALAR"}};
  for (int degree = 0; degree <= sh_degree; ++degree) {
    for (int i = 0; i <= 2 * degree; ++i) {
      list.emplace_back(fmt::format("KHR_gaussian_splatting:SH_DEGREE_{}_COEF_{}", degree, i),
                        "VEC3");
    }
  }
  return list;
}

std::array<json, 2> gltf_bounds(const SplatCloud& cloud) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const glm::vec3& position : cloud.positions) {
    low = glm::min(low, turn_position(position));
    high = glm::max(high, turn_position(position));
  }
  return {json{low.x, low.y, low.z}, json{high.x, high.y, high.z}};
}

json add_plain_attributes(const SplatCloud& cloud, GltfBuilder& builder) {
  json named = json::object();
  const auto add = [&](const std::string& semantic, std::size_t bytes, json accessor) {
    accessor["bufferView"] = builder.add_view(bytes * cloud.size(), true);
    accessor["count"] = cloud.size();
    named[semantic] = builder.add_accessor(std::move(accessor));
  };
  for (const auto& [semantic, type] : splat_semantics(cloud.sh_degree)) {
    json accessor = {{"componentType", kGltfFloat}, {"type", type}};
    const bool first = named.empty();
    if (first) {
      auto [low, high] = gltf_bounds(cloud);
      accessor["min"] = std::move(low);
      accessor["max"] = std::move(high);
    }
    add(semantic, 4 * floats_of(type), std::move(accessor));
    if (first)
      add("COLOR_0", 4,
          {{"componentType", kGltfUnsignedByte}, {"type", "VEC4"}, {"normalized", true}});
  }
  return named;
}

std::byte* put_plain_attributes(const SplatCloud& cloud, std::byte* at) {
  Output out{at};
  for (const glm::vec3& position : cloud.positions) out.put_vec3(turn_position(position));
  for (std::size_t i = 0; i < cloud.size(); ++i)
    out.put(fallback_colour(cloud.sh_dc[i], cloud.opacity_logits[i]));
  for (const glm::quat& rotation : cloud.rotations) {
    const glm::quat q = turn_to_gltf(unit(rotation));
    for (const float c : {q.x, q.y, q.z, q.w}) out.put(c);
  }
  for (const glm::vec3& s : cloud.log_scales) {
    for (int c = 0; c < 3; ++c) out.put(linear_scale(s[c]));
  }
  for (const float opacity : cloud.opacity_logits) out.put(opacity_of(opacity));
  for (const glm::vec3& dc : cloud.sh_dc) out.put_vec3(dc);
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      out.put_vec3(cloud.sh_rest[i * rest + k] * turn_sign(k));
    }
  }
  return out.at;  // all of them take multiples of 4
}

}  // namespace fluxgs::io
