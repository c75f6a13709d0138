#include "fluxgs/io/scene.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "fluxgs/io/compressed_ply.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/io/sog.h"
#include "fluxgs/io/splat.h"
#include "fluxgs/io/spz.h"
#include "io/lower_case.h"
#include "io/other_content.h"
#include "io/splat/spatial_order.h"
#include "io/splat/splat_record.h"
#include "io/whole_cloud.h"

namespace fluxgs {
namespace {

using Bytes = std::vector<std::byte>;

// A reader that needs all bytes at once.
template <Expected<SceneFile> (*read)(std::span<const std::byte>, const std::string&, SplatSink&)>
Expected<SceneFile> of_all(const ByteSource& source, const std::string& name, SplatSink& sink) {
  Bytes room;
  const auto bytes = source.read(0, static_cast<std::size_t>(source.size()), room);
  if (!bytes) return std::unexpected(bytes.error());
  return read(*bytes, name, sink);
}

Expected<SceneFile> read_spz_of_any_axes(std::span<const std::byte> bytes, const std::string& name,
                                         SplatSink& sink) {
  return read_spz(bytes, name, sink);
}

// The app only reads: without this table's mention of them, the linker leaves the writers out.
#ifdef FLUXGS_PHONE
#define FLUXGS_WRITER(function) nullptr
#else
#define FLUXGS_WRITER(function) function
#endif

// A page has no folders.
#ifdef FLUXGS_WEB
#define FLUXGS_FOLDER(function) nullptr
#else
#define FLUXGS_FOLDER(function) function
#endif

// A writer without options.
template <Expected<Bytes> (*encode)(const SplatCloud&, const std::string&)>
Expected<Bytes> plain(const SplatCloud& cloud, const std::string& name, const WriteOptions&) {
  return encode(cloud, name);
}

#ifndef FLUXGS_PHONE
// A writer that takes the start view.
template <Expected<Bytes> (*encode)(const SplatCloud&, const std::string&,
                                    const std::optional<InitialView>&)>
Expected<Bytes> with_start(const SplatCloud& cloud, const std::string& name,
                           const WriteOptions& options) {
  return encode(cloud, name, options.start);
}

std::vector<std::uint32_t> order_in_space(const SplatCloud& cloud) {
  return io::spatial_order(cloud.positions);
}

Expected<Bytes> glb_with_start(const SplatCloud& cloud, const std::string& name,
                               const WriteOptions& options) {
  auto bytes = encode_glb(cloud, name);
  return bytes && options.start ? with_initial_view(*bytes, *options.start, name) : bytes;
}
#endif

// A content goes to the first format that recognises it. Compressed .ply comes before .ply, of
// which it is a special case; .splat has no magic and is guessed, and so comes last.
constexpr auto kFormats = std::to_array<SceneFormat>({
    {"compressed.ply", "compressed .ply of SuperSplat", ".compressed.ply", 3, StoredFilter::all,
     is_compressed_ply, of_all<read_compressed_ply>, false,
     FLUXGS_WRITER(with_start<encode_compressed_ply>), nullptr, FLUXGS_WRITER(order_in_space)},
    {"ply", "3DGS .ply", ".ply", 3, StoredFilter::all, is_ply, read_ply, true,
     FLUXGS_WRITER(with_start<encode_ply>)},
    {"glb", "glTF binary with KHR_gaussian_splatting", ".glb", 3, StoredFilter::all, is_glb,
     read_glb, false, FLUXGS_WRITER(glb_with_start), FLUXGS_FOLDER(read_gltf_folder)},
    {"spz", "SPZ (Niantic)", ".spz", 3, StoredFilter::compensation, is_spz,
     of_all<read_spz_of_any_axes>, false, FLUXGS_WRITER(write_spz)},
    {"sog", "bundled SOG", ".sog", 3, StoredFilter::all, is_sog, of_all<read_sog>, false,
     FLUXGS_WRITER(encode_sog), nullptr, FLUXGS_WRITER(order_in_space)},
    {"sog-folder", "SOG's meta.json", ".json", 3, StoredFilter::all, is_sog_meta, nullptr, false,
     nullptr, FLUXGS_FOLDER(read_sog_folder)},
    {"sog-lod", "streamed SOG's lod-meta.json", ".json", 3, StoredFilter::all, is_sog_lod, nullptr,
     false, nullptr, FLUXGS_FOLDER(read_sog_lod)},
    {"gltf", "glTF with KHR_gaussian_splatting", ".gltf", 3, StoredFilter::all, is_gltf,
     of_all<read_gltf>, false, nullptr, FLUXGS_FOLDER(read_gltf_folder)},
    {"splat", ".splat (32 bytes a splat, unit quaternions)", ".splat", 0, StoredFilter::none,
     is_splat, read_splat, true, FLUXGS_WRITER(plain<encode_splat>)},
});

void append(std::string& list, std::string_view item) {
  list += fmt::format("{}{}", list.empty() ? "" : ", ", item);
}

std::string descriptions() {
  std::string list;
  for (const SceneFormat& format : kFormats) append(list, format.description);
  return list;
}

// Remark on the size of a file named .splat; empty where that is right.
std::string tail_of_splat(std::span<const std::byte> bytes, const std::string& name) {
  const std::size_t record = sizeof(io::SplatRecord), tail = bytes.size() % record;
  if (tail == 0 || !io::lower_case(name).ends_with(".splat")) return "";
  return fmt::format(" (as a .splat its {} bytes would be no multiple of {})", bytes.size(),
                     record);
}

const SceneFormat* find_format(std::span<const std::byte> bytes) {
  const auto found = std::ranges::find_if(
      kFormats, [&](const SceneFormat& format) { return format.recognises(bytes); });
  return found != kFormats.end() ? &*found : nullptr;
}

}  // namespace

bool SceneFormat::stores(const ScreenFilter& filter) const {
  switch (stored_filter) {
    case StoredFilter::none:
      return filter == ScreenFilter{};
    case StoredFilter::compensation:
      return filter.dilation == ScreenFilter{}.dilation;
    case StoredFilter::all:
      break;
  }
  return true;
}

std::span<const SceneFormat> scene_formats() { return kFormats; }

std::string writable_extensions() {
  std::string list;
  for (const SceneFormat& format : kFormats) {
    if (format.encode != nullptr) append(list, format.extension);
  }
  return list;
}

Expected<const SceneFormat*> scene_format_for(const std::filesystem::path& path) {
  const std::string file = io::lower_case(path.filename().string());
  for (const SceneFormat& format : kFormats) {
    if (!file.ends_with(format.extension) || file == format.extension) continue;
    if (format.encode != nullptr) return &format;
    return fail(path.string(), "extension",
                fmt::format("\"{}\" ({}) can be read but not written; expected one of {}",
                            format.extension, format.description, writable_extensions()));
  }
  return fail(path.string(), "extension",
              fmt::format("\"{}\" is not a scene format; expected one of {}",
                          io::lower_case(path.extension().string()), writable_extensions()));
}

Expected<const SceneFormat*> recognise_scene(std::span<const std::byte> bytes,
                                             const std::string& name) {
  if (bytes.empty()) return fail(name, "", "the file is empty; expected a scene");
  const SceneFormat* format = find_format(bytes);
  if (format == nullptr) {
    const std::string other = io::describe_other_content(bytes);
    return fail(name, "format",
                fmt::format("the content {}{}; expected one of: {}",
                            other.empty() ? "is of no known scene format" : other,
                            tail_of_splat(bytes, name), descriptions()));
  }
  if (format->read == nullptr) {
    return fail(name, "format",
                fmt::format("{} names other files; expected the path of a file", format->name));
  }
  return format;
}

Expected<const SceneFormat*> recognise_beginning(std::span<const std::byte> begin,
                                                 const std::string& name) {
  // .splat is known by its size, too
  const std::size_t part = begin.size() % sizeof(io::SplatRecord);
  return recognise_scene(begin.first(begin.size() - part), name);
}

Expected<SceneFile> read_scene(std::span<const std::byte> bytes, const std::string& name) {
  const auto format = recognise_scene(bytes, name);
  if (!format) return std::unexpected(format.error());
  return io::read_whole(
      name, [&](SplatSink& sink) { return read_scene(**format, MemoryBytes(bytes), name, sink); });
}

Expected<SceneFile> read_scene(const SceneFormat& format, const ByteSource& source,
                               const std::string& name, SplatSink& sink) {
  auto scene = format.read(source, name, sink);
  if (!scene) return scene;
  scene->format = format.name;
  scene->bytes = static_cast<std::size_t>(source.size());
  return scene;
}

Expected<SceneFile> read_scene(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return std::unexpected(bytes.error());
  const SceneFormat* format = find_format(*bytes);
  if (format == nullptr || format->read_with_folder == nullptr) {
    return read_scene(*bytes, path.string());
  }
  auto scene = format->read_with_folder(*bytes, path);
  if (scene) scene->format = format->name;
  return scene;
}

Expected<void> write_scene(const std::filesystem::path& path, const SplatCloud& cloud,
                           const WriteOptions& options) {
  const auto format = scene_format_for(path);
  if (!format) return std::unexpected(format.error());
  const auto bytes = (*format)->encode(cloud, path.string(), options);
  if (!bytes) return std::unexpected(bytes.error());
  return write_file_atomic(path, *bytes);
}

}  // namespace fluxgs
