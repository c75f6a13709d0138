// Hand-made and damaged .glb files for the tests.
#pragma once

#include <map>

#include <fmt/format.h>

#include "fluxgs/io/gltf.h"
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

inline Bytes small_glb(std::size_t count = 2, int degree = 1) {
  return *encode_glb(random_cloud(count, degree), "small.glb");
}

inline Expected<SceneFile> read(const Bytes& glb) { return read_glb(glb, "test.glb"); }

}  // namespace fluxgs::test
