#include "fluxgs/io/scene.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

#include "fluxgs/io/file.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/ply.h"

namespace fluxgs {
namespace {

constexpr std::array<SceneFormat, 2> kFormats{{
    {"ply", "3DGS .ply", ".ply", is_ply, read_ply, encode_ply},
    {"glb", "glTF binary with KHR_gaussian_splatting", ".glb", is_glb, read_glb, encode_glb},
}};

std::string lower_extension(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string list(std::string_view SceneFormat::* member) {
  std::string text;
  for (const SceneFormat& format : kFormats) {
    text += fmt::format("{}{}", text.empty() ? "" : ", ", format.*member);
  }
  return text;
}

}  // namespace

std::span<const SceneFormat> scene_formats() { return kFormats; }

Expected<const SceneFormat*> scene_format_for(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  for (const SceneFormat& format : kFormats) {
    if (format.extension == extension) return &format;
  }
  return fail(path.string(), "extension",
              fmt::format("\"{}\" is not a scene format; expected one of {}", extension,
                          list(&SceneFormat::extension)));
}

Expected<SceneFile> read_scene(std::span<const std::byte> bytes, const std::string& name) {
  for (const SceneFormat& format : kFormats) {
    if (!format.recognises(bytes)) continue;
    auto scene = format.read(bytes, name);
    if (!scene) return scene;
    scene->format = format.name;
    scene->bytes = bytes.size();
    return scene;
  }
  if (bytes.empty()) return fail(name, "", "the file is empty; expected a scene");
  return fail(name, "format",
              fmt::format("the content is of no known scene format; expected one of: {}",
                          list(&SceneFormat::description)));
}

Expected<SceneFile> read_scene(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return std::unexpected(bytes.error());
  return read_scene(*bytes, path.string());
}

Expected<void> write_scene(const std::filesystem::path& path, const SplatCloud& cloud) {
  const auto format = scene_format_for(path);
  if (!format) return std::unexpected(format.error());
  const auto bytes = (*format)->encode(cloud, path.string());
  if (!bytes) return std::unexpected(bytes.error());
  return write_file_atomic(path, *bytes);
}

}  // namespace fluxgs
