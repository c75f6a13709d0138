#include <algorithm>
#include <exception>
#include <initializer_list>
#include <string_view>

#include <fmt/format.h>

#include "fluxgs/io/sog.h"
#include "fluxgs/sanitize.h"
#include "io/json_text.h"
#include "io/sog/folder_files.h"
#include "io/sog/sog_decode.h"
#include "io/sog/sog_lod.h"
#include "io/sog/sog_meta.h"
#include "io/sog/zip_archive.h"
#include "io/whole_cloud.h"

namespace fluxgs {
namespace {

using namespace io;

constexpr char kMetaFile[] = "meta.json";

constexpr std::string_view kZipMagic = "PK\x03\x04";  // of a file's header (APPNOTE 4.3.7)

// Whether a text is an object and names all of `keys`; no more is looked at.
bool is_object_with(std::span<const std::byte> bytes,
                    std::initializer_list<std::string_view> keys) {
  const std::string_view text = as_text(bytes.first(std::min(bytes.size(), kMaxJsonText)));
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin != text.npos && text[begin] == '{' &&
         std::ranges::all_of(keys, [&](std::string_view key) { return text.contains(key); });
}

// Passes files on and adds up what each attribute takes, compressed; sh0 holds opacity too.
NamedFiles counted(NamedFiles files, AttributeBits& bits) {
  return [files = std::move(files), &bits](const std::string& file, std::uint64_t max_bytes) {
    auto content = files(file, max_bytes);
    const std::string_view base = std::string_view(file).substr(file.rfind('/') + 1);
    for (const auto& [start, attribute] :
         {std::pair("means", "position"), std::pair("scales", "scale"),
          std::pair("quats", "rotation"), std::pair("sh0", "sh_dc"), std::pair("shN", "sh_rest")})
      if (content && base.starts_with(start))
        bits[attribute] += 8.0 * static_cast<double>(content->size());
    return content;
  };
}

// What is said about splats that went into a sink; `bits` are of all of them.
void describe(const char* format, std::size_t splats, std::size_t bytes, AttributeBits bits,
              SceneFile& scene) {
  for (auto& [attribute, total] : bits)
    total /= static_cast<double>(std::max<std::size_t>(splats, 1));
  scene.attribute_bits = std::move(bits);
  scene.format = format;
  scene.bytes = bytes;
}

// Parsing takes memory that is not asked for as a value.
template <class Read>
auto within_memory(const std::string& name, Read read) -> decltype(read()) {
  try {
    return read();
  } catch (const std::exception&) {  // bad_alloc, or length_error beyond what a vector can count
    return fail(name, "memory", "out of memory reading the scene");
  }
}

Expected<SogMeta> meta_from(std::span<const std::byte> json, const std::string& field,
                            const std::string& name) {
  const auto root = parse_json_object(as_text(json), name, field);
  if (!root) return std::unexpected(root.error());
  return parse_sog_meta(*root, name, field);
}

// Returns how many splats it announces.
Expected<std::size_t> read_from(std::span<const std::byte> json, const NamedFiles& files,
                                const std::string& folder, const std::string& field,
                                const std::string& name, SplatSink& sink, SceneFile& scene) {
  const auto meta = meta_from(json, field, name);
  if (!meta) return std::unexpected(meta.error());
  if (auto done = decode_sog(*meta, files, folder, name, sink, scene); !done)
    return std::unexpected(done.error());
  return meta->count;
}

// The scene of an archive.
struct BundledMeta {
  SogMeta meta;
  std::string folder;  // "", or with a slash at its end: where meta.json and the images lie
};

// The one meta.json that lies highest: a folder may have been packed as a whole.
Expected<std::string> find_meta(const ZipArchive& archive, const std::string& name) {
  const auto depth = [](const std::string& file) { return std::ranges::count(file, '/'); };
  std::vector<std::string> found;
  for (const std::string& file : archive.files()) {
    const std::string_view base = std::string_view(file).substr(file.rfind('/') + 1);
    if (base == "lod-meta.json")
      return fail(name, file, "names a streamed scene; unpack the archive and open this file");
    if (base == kMetaFile) found.push_back(file);
  }
  if (found.empty()) return fail(name, kMetaFile, "is not in the archive");
  std::ranges::stable_sort(found, {}, depth);
  if (found.size() == 1 || depth(found[0]) < depth(found[1])) return found[0];
  return fail(name, found[1],
              fmt::format("is a second scene beside {}; unpack the archive and open one of them",
                          sanitized(found[0])));
}

// Its images may be compressed once more, and tell of far more than it has bytes for.
Expected<BundledMeta> archive_meta(const ZipArchive& archive, std::size_t bytes,
                                   const std::string& name) {
  const auto file = find_meta(archive, name);
  if (!file) return std::unexpected(file.error());
  const auto json = archive.read(*file, kMaxJsonText);
  if (!json) return std::unexpected(json.error());
  auto meta = meta_from(*json, kMetaFile, name);
  if (!meta) return std::unexpected(meta.error());
  if (meta->count > max_sog_splats(bytes))
    return fail(name, kMetaFile,
                fmt::format("announces {} splats; an archive of {} bytes has at most {}",
                            meta->count, bytes, max_sog_splats(bytes)));
  return BundledMeta{std::move(*meta), file->substr(0, file->size() - (sizeof kMetaFile - 1))};
}

NamedFiles reader_of(const ZipArchive& archive) {
  return [&archive](const std::string& file, std::uint64_t max_bytes) {
    return archive.read(file, max_bytes);
  };
}

Expected<SceneFile> read_chunk(const SogChunk& chunk, const NamedFiles& files,
                               const std::string& name) {
  const auto json = files(chunk.file, kMaxJsonText);
  if (!json) return std::unexpected(json.error());
  const std::string folder = chunk.file.substr(0, chunk.file.rfind('/') + 1);
  return read_whole(name, [&](SplatSink& sink) -> Expected<SceneFile> {
    SceneFile scene;
    const auto count = read_from(*json, files, folder, chunk.file, name, sink, scene);
    if (!count) return std::unexpected(count.error());
    if (*count != chunk.count) {
      return fail(name, chunk.file,
                  fmt::format("holds {} splats; the tree of lod-meta.json expects {}", *count,
                              chunk.count));
    }
    return scene;
  });
}

void raise_degree(SplatCloud& cloud, int degree) {
  if (cloud.sh_degree >= degree) return;
  const auto old_rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const auto new_rest = static_cast<std::size_t>(sh_rest_count(degree));
  std::vector<glm::vec3> raised(cloud.size() * new_rest, glm::vec3(0));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::copy_n(cloud.sh_rest.data() + i * old_rest, old_rest, raised.data() + i * new_rest);
  }
  cloud.sh_rest = std::move(raised);
  cloud.sh_degree = degree;
}

void append(SplatCloud& to, SplatCloud from) {
  if (to.size() == 0) {
    to = std::move(from);
    return;
  }
  raise_degree(to, from.sh_degree);
  raise_degree(from, to.sh_degree);
  const auto join = [](auto& a, const auto& b) { a.insert(a.end(), b.begin(), b.end()); };
  join(to.positions, from.positions);
  join(to.log_scales, from.log_scales);
  join(to.rotations, from.rotations);
  join(to.opacity_logits, from.opacity_logits);
  join(to.sh_dc, from.sh_dc);
  join(to.sh_rest, from.sh_rest);
}

NamedFiles reader_of(FolderFiles& folder) {
  return [&folder](const std::string& file, std::uint64_t max_bytes) {
    return folder.read(file, max_bytes);
  };
}

}  // namespace

bool is_sog(std::span<const std::byte> bytes) {
  // Names stand before the files and, all together, at the end.
  constexpr std::size_t kBegin = 4096, kEnd = 65536;
  const std::string_view text = as_text(bytes);
  if (!text.starts_with(kZipMagic)) return false;
  const auto names_scene = [](std::string_view part) {
    return part.contains(kMetaFile) || part.contains(".webp");
  };
  return names_scene(text.substr(0, kBegin)) ||
         names_scene(text.substr(text.size() - std::min(text.size(), kEnd)));
}

Expected<SceneFile> read_sog(std::span<const std::byte> bytes, const std::string& name,
                             SplatSink& sink) {
  return within_memory(name, [&]() -> Expected<SceneFile> {
    const auto archive = ZipArchive::open(bytes, name);
    if (!archive) return std::unexpected(archive.error());
    const auto found = archive_meta(*archive, bytes.size(), name);
    if (!found) return std::unexpected(found.error());
    AttributeBits bits;
    SceneFile scene;
    const auto done = decode_sog(found->meta, counted(reader_of(*archive), bits), found->folder,
                                 name, sink, scene);
    if (!done) return std::unexpected(done.error());
    describe("sog", found->meta.count - scene.dropped, bytes.size(), std::move(bits), scene);
    return scene;
  });
}

Expected<SceneFile> read_sog(std::span<const std::byte> bytes, const std::string& name) {
  return read_whole(name, [&](SplatSink& sink) { return read_sog(bytes, name, sink); });
}

Expected<std::pair<std::size_t, int>> announced_by_sog(std::span<const std::byte> bytes,
                                                       const std::string& name) {
  return within_memory(name, [&]() -> Expected<std::pair<std::size_t, int>> {
    const auto archive = ZipArchive::open(bytes, name);
    if (!archive) return std::unexpected(archive.error());
    const auto scene = archive_meta(*archive, bytes.size(), name);
    if (!scene) return std::unexpected(scene.error());
    const SogMeta& meta = scene->meta;
    return std::pair(meta.count, meta.sh ? meta.sh->degree.value_or(3) : 0);
  });
}

bool is_sog_meta(std::span<const std::byte> bytes) {
  return is_object_with(bytes, {"\"means\"", "\"quats\"", "\"scales\""});
}

Expected<SceneFile> read_sog_folder(std::span<const std::byte> bytes,
                                    const std::filesystem::path& path) {
  const std::string name = path.string();
  return within_memory(name, [&]() -> Expected<SceneFile> {
    FolderFiles folder(path.parent_path());
    AttributeBits bits;
    return read_whole(name, [&](SplatSink& sink) -> Expected<SceneFile> {
      SceneFile scene;
      const auto count =
          read_from(bytes, counted(reader_of(folder), bits), "", kMetaFile, name, sink, scene);
      if (!count) return std::unexpected(count.error());
      describe("sog-folder", *count - scene.dropped, bytes.size() + folder.bytes(), std::move(bits),
               scene);
      return scene;
    });
  });
}

bool is_sog_lod(std::span<const std::byte> bytes) {
  return is_object_with(bytes, {"\"lodLevels\"", "\"filenames\"", "\"tree\""});
}

Expected<SceneFile> read_sog_lod(std::span<const std::byte> bytes,
                                 const std::filesystem::path& path) {
  const std::string name = path.string();
  return within_memory(name, [&]() -> Expected<SceneFile> {
    const auto root = parse_json_object(as_text(bytes), name, "lod-meta.json");
    if (!root) return std::unexpected(root.error());
    const auto chunks = parse_sog_lod(*root, name);
    if (!chunks) return std::unexpected(chunks.error());
    FolderFiles folder(path.parent_path());
    AttributeBits bits;
    const NamedFiles files = counted(reader_of(folder), bits);
    SceneFile scene;
    for (const SogChunk& chunk : *chunks) {
      auto part = read_chunk(chunk, files, name);
      if (!part) return std::unexpected(part.error());
      scene.dropped += part->dropped;
      append(scene.cloud, std::move(part->cloud));
    }
    describe("sog-lod", scene.cloud.size(), bytes.size() + folder.bytes(), std::move(bits), scene);
    return scene;
  });
}

}  // namespace fluxgs
