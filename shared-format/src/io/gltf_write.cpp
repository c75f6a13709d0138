#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "activation.h"
#include "cloud_memory.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/math/projection.h"
#include "glb_container.h"
#include "gltf_frame.h"
#include "gltf_json.h"

namespace fluxgs {
namespace {

using nlohmann::json;

// glTF 2.0, sections 5.1 and 5.11.
constexpr int kFloatType = 5126, kUnsignedByteType = 5121, kArrayBuffer = 34962, kPoints = 0;

struct Attribute {
  std::string semantic;
  const char* type;
  int component_type;
  std::size_t bytes;  // per splat, a multiple of 4
};

std::vector<Attribute> attributes_of(int sh_degree) {
  std::vector<Attribute> list{{"POSITION", "VEC3", kFloatType, 12},
                              {"COLOR_0", "VEC4", kUnsignedByteType, 4},
                              {"KHR_gaussian_splatting:ROTATION", "VEC4", kFloatType, 16},
                              {"KHR_gaussian_splatting:SCALE", "VEC3", kFloatType, 12},
                              {"KHR_gaussian_splatting:OPACITY", "SCALAR", kFloatType, 4}};
  for (int degree = 0; degree <= sh_degree; ++degree) {
    for (int i = 0; i <= 2 * degree; ++i) {
      list.push_back({fmt::format("KHR_gaussian_splatting:SH_DEGREE_{}_COEF_{}", degree, i), "VEC3",
                      kFloatType, 12});
    }
  }
  return list;
}

// The bounds that glTF requires of POSITION. Floats become doubles without loss.
std::array<json, 2> bounds_of(const SplatCloud& cloud) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const glm::vec3& position : cloud.positions) {
    low = glm::min(low, io::turn_position(position));
    high = glm::max(high, io::turn_position(position));
  }
  return {json{low.x, low.y, low.z}, json{high.x, high.y, high.z}};
}

json document_of(const SplatCloud& cloud, const std::vector<Attribute>& attributes) {
  json root = {{"asset", {{"version", "2.0"}, {"generator", "Flux-GS"}}},
               {"extensionsUsed", json::array({io::kSplatExtension})},
               {"scene", 0}};
  if (cloud.size() == 0) {
    root["scenes"] = json::array({json::object()});
    return root;
  }
  json accessors = json::array(), views = json::array(), named = json::object();
  std::size_t offset = 0;
  for (const Attribute& attribute : attributes) {
    const std::size_t length = attribute.bytes * cloud.size();
    named[attribute.semantic] = accessors.size();
    accessors.push_back({{"bufferView", views.size()},
                         {"componentType", attribute.component_type},
                         {"count", cloud.size()},
                         {"type", attribute.type}});
    if (attribute.component_type != kFloatType) accessors.back()["normalized"] = true;
    views.push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}, {"target", kArrayBuffer}});
    offset += length;
  }
  auto [low, high] = bounds_of(cloud);
  accessors[0]["min"] = std::move(low);
  accessors[0]["max"] = std::move(high);
  const json extension = {{"kernel", "ellipse"},
                          {"colorSpace", "srgb_rec709_display"},
                          {"sortingMethod", "cameraDistance"},
                          {"projection", "perspective"}};
  root["scenes"] = json::array({{{"nodes", json::array({0})}}});
  root["nodes"] = json::array({{{"mesh", 0}}});
  root["buffers"] = json::array({{{"byteLength", offset}}});
  root["bufferViews"] = std::move(views);
  root["accessors"] = std::move(accessors);
  const json primitive = {
      {"attributes", named}, {"mode", kPoints}, {"extensions", {{io::kSplatExtension, extension}}}};
  root["meshes"] = json::array({{{"primitives", json::array({primitive})}}});
  return root;
}

// COLOR_0 is linear, the colours of the splats are sRGB-encoded (the extension's note on fallback
// behaviour; IEC 61966-2-1).
std::uint8_t fallback_colour(float dc) {
  const double c = std::clamp(io::colour_of(dc), 0.0, 1.0);
  return io::byte_of(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
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

// The attributes one after the other, in the order of attributes_of.
void put_splats(const SplatCloud& cloud, Output out) {
  for (const glm::vec3& position : cloud.positions) out.put_vec3(io::turn_position(position));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int c = 0; c < 3; ++c) out.put(fallback_colour(cloud.sh_dc[i][c]));
    out.put(io::byte_of(io::sigmoid(cloud.opacity_logits[i])));
  }
  for (const glm::quat& rotation : cloud.rotations) {
    const glm::quat q = io::turn_to_gltf(unit(rotation));
    for (const float c : {q.x, q.y, q.z, q.w}) out.put(c);
  }
  for (const glm::vec3& s : cloud.log_scales) {
    for (int c = 0; c < 3; ++c) out.put(io::linear_scale(s[c]));
  }
  for (const float opacity : cloud.opacity_logits) out.put(io::sigmoid(opacity));
  for (const glm::vec3& dc : cloud.sh_dc) out.put_vec3(dc);
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      out.put_vec3(cloud.sh_rest[i * rest + k] * io::turn_sign(k));
    }
  }
}

}  // namespace

Expected<std::vector<std::byte>> encode_glb(const SplatCloud& cloud, const std::string& name) {
  SplatCloud storage;
  const auto finite = io::writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  const SplatCloud& splats = **finite;
  const auto attributes = attributes_of(splats.sh_degree);
  std::size_t per_splat = 0;
  for (const Attribute& attribute : attributes) per_splat += attribute.bytes;

  std::string text = document_of(splats, attributes).dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::uint64_t bin = std::uint64_t{per_splat} * splats.size();
  const std::uint64_t total = io::kGlbHeader + io::kGlbChunkHeader + text.size() +
                              (bin > 0 ? io::kGlbChunkHeader + bin : 0);
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return fail(name, "size",
                fmt::format("{} splats need {} bytes; a .glb holds less than 4 GiB (a .ply more)",
                            splats.size(), total));
  }
  auto bytes = io::allocate_bytes(static_cast<std::size_t>(total), name);
  if (!bytes) return bytes;
  Output out{bytes->data()};
  out.put(io::kGlbMagic);
  out.put(std::uint32_t{2});
  out.put(static_cast<std::uint32_t>(total));
  out.put(static_cast<std::uint32_t>(text.size()));
  out.put(std::uint32_t{io::kGlbJson});
  std::memcpy(out.at, text.data(), text.size());
  out.at += text.size();
  if (bin == 0) return bytes;
  out.put(static_cast<std::uint32_t>(bin));
  out.put(std::uint32_t{io::kGlbBin});
  put_splats(splats, out);
  return bytes;
}

}  // namespace fluxgs
