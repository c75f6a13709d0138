// Hand-made and damaged .glb files for the tests.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/gltf.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "support.h"

namespace fluxgs::test {

inline std::uint32_t u32_at(const Bytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

inline std::string json_of(const Bytes& glb) {
  return text_of(std::span(glb).subspan(20, u32_at(glb, 12)));
}
inline Bytes bin_of(const Bytes& glb) {
  const std::size_t at = 20 + u32_at(glb, 12);
  if (at >= glb.size()) return {};
  return Bytes(glb.begin() + static_cast<std::ptrdiff_t>(at) + 8, glb.end());
}

inline Bytes make_glb(std::string json, Bytes bin = {}) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  bin.resize((bin.size() + 3) / 4 * 4);
  const std::size_t total = 20 + json.size() + (bin.empty() ? 0 : 8 + bin.size());
  Bytes glb = bytes_of("glTF");
  append(glb, std::uint32_t{2});
  append(glb, static_cast<std::uint32_t>(total));
  append(glb, static_cast<std::uint32_t>(json.size()));
  append(glb, std::uint32_t{0x4E4F534A});
  const Bytes text = bytes_of(json);
  glb.insert(glb.end(), text.begin(), text.end());
  if (bin.empty()) return glb;
  append(glb, static_cast<std::uint32_t>(bin.size()));
  append(glb, std::uint32_t{0x004E4942});
  glb.insert(glb.end(), bin.begin(), bin.end());
  return glb;
}

/// The file with one piece of its JSON replaced; the piece must be there.
inline Bytes edited(const Bytes& glb, const std::string& from, const std::string& to) {
  std::string json = json_of(glb);
  const std::size_t at = json.find(from);
  EXPECT_NE(at, std::string::npos) << "no " << from << " in " << json;
  if (at != std::string::npos) json.replace(at, from.size(), to);
  return make_glb(json, bin_of(glb));
}

/// The primitives of all files, made by our writers, in the first one's mesh.
inline Bytes joined_glb(const std::vector<Bytes>& files) {
  using nlohmann::json;
  json root;
  Bytes bin;
  for (const Bytes& file : files) {
    json next = json::parse(json_of(file));
    if (root.is_null()) {
      root = next;
      for (const char* list : {"accessors", "bufferViews"}) root[list] = json::array();
      root["meshes"][0]["primitives"] = root["extensionsUsed"] = json::array();
    }
    const std::size_t accessors = root["accessors"].size(), views = root["bufferViews"].size();
    const auto shift = [](json& index, std::size_t by) { index = index.get<std::size_t>() + by; };
    for (json view : next["bufferViews"]) {
      view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + bin.size();
      root["bufferViews"].push_back(view);
    }
    for (json accessor : next["accessors"]) {
      if (accessor.contains("bufferView")) shift(accessor["bufferView"], views);
      root["accessors"].push_back(accessor);
    }
    for (json primitive : next["meshes"][0]["primitives"]) {
      for (auto& index : primitive["attributes"]) shift(index, accessors);
      json& splats = primitive["extensions"]["KHR_gaussian_splatting"];
      if (splats.contains("extensions"))
        for (auto& nested : splats["extensions"]) shift(nested["bufferView"], views);
      root["meshes"][0]["primitives"].push_back(primitive);
    }
    for (const json& used : next["extensionsUsed"])
      if (std::ranges::find(root["extensionsUsed"], used) == root["extensionsUsed"].end())
        root["extensionsUsed"].push_back(used);
    const Bytes own = bin_of(file);
    bin.insert(bin.end(), own.begin(), own.end());
  }
  root.erase("extensionsRequired");
  root["buffers"][0]["byteLength"] = bin.size();
  return make_glb(root.dump(), bin);
}

inline Bytes small_glb(std::size_t count = 2, int degree = 1) {
  return *encode_glb(random_cloud(count, degree), "small.glb");
}

/// The colour of a splat along a direction, less 1/2, from the specification's formula, independent
/// of the reader.
inline glm::dvec3 colour(const SplatCloud& cloud, std::size_t i, const glm::dvec3& direction) {
  std::array<double, 15> basis{};
  math::sh_basis(cloud.sh_degree, {direction.x, direction.y, direction.z}, basis.data());
  glm::dvec3 sum = math::kSh0 * glm::dvec3(cloud.sh_dc[i]);
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) sum += basis[k] * glm::dvec3(cloud.sh_rest[i * rest + k]);
  return sum;
}

inline std::string base64(const Bytes& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group =
          group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

inline Expected<SceneFile> read(const Bytes& glb) { return read_glb(glb, "test.glb"); }

}  // namespace fluxgs::test
