#include "io/gltf/gltf_quantized.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "cloud/activation.h"
#include "fluxgs/io/gltf_frame.h"
#include "fluxgs/math/projection.h"
#include "io/gltf/gltf_plain.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

// Smallest class worth its description in the JSON: fewer splats save less than that takes.
constexpr std::size_t kMinClass = 64;

struct Component {
  int type;
  std::size_t count, bytes;
  bool normalized;

  // Elements begin at multiples of 4 (glTF 2.0, 3.6.2.4).
  std::size_t stride() const { return (count * bytes + 3) / 4 * 4; }
};

Component component_of(const std::string& semantic, const std::string& type, int bits) {
  const std::size_t count = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
  const std::size_t bytes = static_cast<std::size_t>(bits / 8);
  if (semantic.ends_with(":ROTATION"))
    return {bits == 8 ? kGltfByte : kGltfShort, count, bytes, true};
  if (semantic.ends_with(":SCALE") || semantic.ends_with(":OPACITY"))
    return {bits == 8 ? kGltfUnsignedByte : kGltfUnsignedShort, count, bytes, true};
  return {kGltfFloat, count, 4, false};
}

/// The least exponent of two above all scales of a splat.
int size_exponent(const glm::vec3& log_scale) {
  int exponent = 0;
  std::frexp(linear_scale(std::max({log_scale.x, log_scale.y, log_scale.z})), &exponent);
  return exponent;
}

/// The least exponent with which positions stay finite.
int least_exponent(const SplatCloud& cloud) {
  float farthest = 0;
  for (const glm::vec3& p : cloud.positions)
    farthest = std::max({farthest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  int exponent = 0;
  std::frexp(farthest, &exponent);
  return std::max(exponent - 126, -126);
}

/// Elements of an attribute, `stride` bytes apart, behind zeros.
class Column {
 public:
  Column(std::byte* at, const Component& component) : at_(at), component_(component) {}

  void floats(const glm::vec3& v) {
    std::memcpy(at_, &v, sizeof v);
    at_ += component_.stride();
  }
  /// Numbers from `least`, −1 or 0, to 1.
  void integers(const double* values, double least) {
    const bool one_byte = component_.bytes == 1;
    const double most = least < 0 ? (one_byte ? 127 : 32767) : (one_byte ? 255 : 65535);
    for (std::size_t i = 0; i < component_.count; ++i) {
      const long level = std::lround(std::clamp(values[i], least, 1.0) * most);
      const auto word = static_cast<std::uint16_t>(level);  // two's complement, low byte first
      std::memcpy(at_ + i * component_.bytes, &word, component_.bytes);
    }
    at_ += component_.stride();
  }
  std::byte* end() const { return at_; }

 private:
  std::byte* at_;
  Component component_;
};

/// Levels of a scale: what is above 0 stays so, for a splat without thickness has no inverse.
double level_scale(float log_scale, double node, int bits) {
  const double value = double{linear_scale(log_scale)} / node;
  return value > 0 ? std::max(value, 1.0 / (bits == 8 ? 255 : 65535)) : 0;
}

glm::vec3 local_position(const glm::vec3& position, double node) {
  return glm::vec3(glm::dvec3(turn_position(position)) / node);
}

}  // namespace

std::vector<SizeClass> size_classes(const SplatCloud& cloud, int bits) {
  const int width = bits == 8 ? 2 : 8, least = least_exponent(cloud);
  std::map<int, std::vector<std::uint32_t>, std::greater<>> by_exponent;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int exponent = std::clamp(size_exponent(cloud.log_scales[i]), least, 127);
    // Rounded up to a multiple of the width
    const int top = exponent + ((-exponent % width) + width) % width;
    by_exponent[std::min(top, 127)].push_back(static_cast<std::uint32_t>(i));
  }
  std::vector<SizeClass> classes;
  for (auto& [exponent, splats] : by_exponent) {
    if (splats.size() >= kMinClass || classes.empty()) {
      classes.push_back({std::ldexp(1.0, exponent), std::move(splats)});
      continue;
    }
    std::vector<std::uint32_t>& larger = classes.back().splats;
    larger.insert(larger.end(), splats.begin(), splats.end());
    std::ranges::sort(larger);
  }
  return classes;
}

json add_quantized_attributes(const SplatCloud& cloud, const SizeClass& one, int bits,
                              GltfBuilder& builder) {
  json named = json::object();
  const auto add = [&](const std::string& semantic, const std::string& type, const Component& c) {
    json accessor = {{"componentType", c.type}, {"type", type}, {"count", one.splats.size()}};
    if (c.normalized) accessor["normalized"] = true;
    const std::size_t close = c.count * c.bytes;
    accessor["bufferView"] = builder.add_view(c.stride() * one.splats.size(), true,
                                              c.stride() == close ? 0 : c.stride());
    if (named.empty()) {
      glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
      for (const std::uint32_t i : one.splats) {
        const glm::vec3 p = local_position(cloud.positions[i], one.scale);
        low = glm::min(low, p), high = glm::max(high, p);
      }
      accessor["min"] = {low.x, low.y, low.z};
      accessor["max"] = {high.x, high.y, high.z};
    }
    named[semantic] = builder.add_accessor(std::move(accessor));
  };
  for (const auto& [semantic, type] : splat_semantics(cloud.sh_degree)) {
    const bool first = named.empty();
    add(semantic, type, component_of(semantic, type, bits));
    if (first) add("COLOR_0", "VEC4", {kGltfUnsignedByte, 4, 1, true});
  }
  return named;
}

std::byte* put_quantized_attributes(const SplatCloud& cloud, const SizeClass& one, int bits,
                                    std::byte* at) {
  const auto column = [&](const std::string& semantic, const std::string& type, const auto& put) {
    Column out(at, component_of(semantic, type, bits));
    for (const std::uint32_t i : one.splats) put(out, i);
    at = out.end();
  };
  column("POSITION", "VEC3", [&](Column& out, std::uint32_t i) {
    out.floats(local_position(cloud.positions[i], one.scale));
  });
  for (const std::uint32_t i : one.splats) {
    const auto colour = fallback_colour(cloud.sh_dc[i], cloud.opacity_logits[i]);
    std::memcpy(at, colour.data(), colour.size());
    at += colour.size();
  }
  column(":ROTATION", "VEC4", [&](Column& out, std::uint32_t i) {
    const glm::quat& r = cloud.rotations[i];
    const math::Quat<double> unit = math::normalized(math::Quat<double>{r.w, r.x, r.y, r.z});
    const glm::quat q = turn_to_gltf(glm::quat(glm::dquat(unit.w, unit.x, unit.y, unit.z)));
    const double values[] = {q.x, q.y, q.z, q.w};
    out.integers(values, -1);
  });
  column(":SCALE", "VEC3", [&](Column& out, std::uint32_t i) {
    const glm::vec3& s = cloud.log_scales[i];
    const double values[] = {level_scale(s.x, one.scale, bits), level_scale(s.y, one.scale, bits),
                             level_scale(s.z, one.scale, bits)};
    out.integers(values, 0);
  });
  column(":OPACITY", "SCALAR", [&](Column& out, std::uint32_t i) {
    const double value = opacity_of(cloud.opacity_logits[i]);
    out.integers(&value, 0);
  });
  column("SH", "VEC3", [&](Column& out, std::uint32_t i) { out.floats(cloud.sh_dc[i]); });
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < rest; ++k)
    column("SH", "VEC3", [&](Column& out, std::uint32_t i) {
      out.floats(cloud.sh_rest[i * rest + k] * turn_sign(k));
    });
  return at;
}

}  // namespace fluxgs::io
