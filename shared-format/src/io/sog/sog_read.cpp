#include <algorithm>
#include <exception>
#include <initializer_list>
#include <set>
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

constexpr std::string_view kMetaFile = "meta.json", kLodFile = "lod-meta.json";
constexpr std::size_t kMostChunks = 4096;  // of a streamed scene, half a million splats each

std::string_view base_of(std::string_view file) { return file.substr(file.rfind('/') + 1); }

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
    const std::string_view base = base_of(file);
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

struct LocatedMeta {
  SogMeta meta;
  std::string folder;  // "", or with a slash at its end: where meta.json and the images lie
};

// The one meta.json or lod-meta.json that lies highest: a folder may have been packed as a whole.
Expected<std::string> find_meta(const ZipArchive& archive, const std::string& name) {
  const auto depth = [](const std::string& file) { return std::ranges::count(file, '/'); };
  std::vector<std::string> found;
  for (const std::string& file : archive.files()) {
    const std::string_view base = base_of(file);
    if (base == kMetaFile || base == kLodFile) found.push_back(file);
  }
  if (found.empty()) return fail(name, std::string(kMetaFile), "is not in the archive");
  std::ranges::stable_sort(found, {}, depth);
  if (found.size() == 1 || depth(found[0]) < depth(found[1])) return found[0];
  return fail(name, found[1],
              fmt::format("is a second scene beside {}; unpack the archive and open one of them",
                          sanitized(found[0])));
}

Expected<std::vector<LocatedMeta>> located_meta(std::span<const std::byte> json,
                                                const std::string& folder,
                                                const std::string& name) {
  auto meta = meta_from(json, std::string(kMetaFile), name);
  if (!meta) return std::unexpected(meta.error());
  return std::vector{LocatedMeta{std::move(*meta), folder}};
}

/// Each file once at most: many names of one would be read for long.
NamedFiles once(NamedFiles files, const std::string& name) {
  return [files = std::move(files), name, used = std::set<std::string>()](
             const std::string& file, std::uint64_t max_bytes) mutable {
    if (used.insert(file).second) return files(file, max_bytes);
    return Expected<std::vector<std::byte>>(
        fail(name, file, "is named twice; expected a file for each purpose"));
  };
}

/// The chunks of a streamed scene that hold its finest level; `folder`: where lod-meta.json lies.
Expected<std::vector<LocatedMeta>> finest_chunks(std::span<const std::byte> json,
                                                 const NamedFiles& files, const std::string& folder,
                                                 const std::string& name) {
  const auto root = parse_json_object(as_text(json), name, std::string(kLodFile));
  if (!root) return std::unexpected(root.error());
  const auto chunks = parse_sog_lod(*root, name);
  if (!chunks) return std::unexpected(chunks.error());
  if (chunks->size() > kMostChunks)
    return fail(
        name, std::string(kLodFile),
        fmt::format("level 0 lies in {} files; at most {} are read", chunks->size(), kMostChunks));
  std::vector<LocatedMeta> found;
  for (const SogChunk& chunk : *chunks) {
    const std::string file = folder + chunk.file;
    const auto text = files(file, kMaxJsonText);
    if (!text) return std::unexpected(text.error());
    auto meta = meta_from(*text, file, name);
    if (!meta) return std::unexpected(meta.error());
    if (meta->count != chunk.count)
      return fail(name, file,
                  fmt::format("holds {} splats; the tree of lod-meta.json expects {}", meta->count,
                              chunk.count));
    found.push_back({std::move(*meta), file.substr(0, file.rfind('/') + 1)});
  }
  return found;
}

/// Takes the splats of a chunk for a sink that knows of the whole scene.
class ChunkSink final : public SplatSink {
 public:
  ChunkSink(SplatSink& sink, int degree) : sink_(sink), degree_(degree) {}
  Expected<int> begin(const ComingSplats& coming) override {
    return std::min(coming.sh_degree, degree_);
  }
  Expected<void> take(SplatCloud& part) override { return sink_.take(part); }

 private:
  SplatSink& sink_;
  int degree_;
};

int degree_of(const SogMeta& meta) { return meta.sh ? meta.sh->degree.value_or(3) : 0; }

std::pair<std::size_t, int> announced_by(const std::vector<LocatedMeta>& scenes) {
  std::pair<std::size_t, int> all;
  for (const LocatedMeta& scene : scenes) {
    all.first += scene.meta.count;
    all.second = std::max(all.second, degree_of(scene.meta));
  }
  return all;
}

/// Hands on the scenes one after the other as one.
Expected<void> decode_all(const std::vector<LocatedMeta>& chunks, const NamedFiles& files,
                          const std::string& name, SplatSink& sink, SceneFile& scene) {
  if (chunks.size() == 1)
    return decode_sog(chunks[0].meta, files, chunks[0].folder, name, sink, scene);
  const auto [count, degree] = announced_by(chunks);
  constexpr std::uint64_t kImages = 6 * sizeof(std::uint32_t);  // bytes of a splat in images
  const auto largest = std::ranges::max_element(
      chunks, {}, [](const LocatedMeta& chunk) { return chunk.meta.count; });
  const auto wanted =
      sink.begin({.count = count, .sh_degree = degree, .held = kImages * largest->meta.count});
  if (!wanted) return std::unexpected(wanted.error());
  ChunkSink chunk_sink(sink, *wanted);
  for (const LocatedMeta& chunk : chunks)
    if (auto done = decode_sog(chunk.meta, files, chunk.folder, name, chunk_sink, scene); !done)
      return done;
  scene.cloud.sh_degree = *wanted;
  return {};
}

NamedFiles reader_of(const ZipArchive& archive) {
  return [&archive](const std::string& file, std::uint64_t max_bytes) {
    return archive.read(file, max_bytes);
  };
}

/// The scene of an archive, or the chunks of one. Its images may be compressed once more, and tell
/// of far more than it has bytes for.
Expected<std::vector<LocatedMeta>> archive_metas(const ZipArchive& archive, const NamedFiles& files,
                                                 std::size_t bytes, const std::string& name) {
  const auto file = find_meta(archive, name);
  if (!file) return std::unexpected(file.error());
  const auto json = files(*file, kMaxJsonText);
  if (!json) return std::unexpected(json.error());
  const std::string folder = file->substr(0, file->rfind('/') + 1);
  auto metas = base_of(*file) == kLodFile ? finest_chunks(*json, files, folder, name)
                                          : located_meta(*json, folder, name);
  if (!metas) return metas;
  const std::size_t count = announced_by(*metas).first;
  if (count > max_sog_splats(bytes))
    return fail(name, std::string(base_of(*file)),
                fmt::format("announces {} splats; an archive of {} bytes has at most {}", count,
                            bytes, max_sog_splats(bytes)));
  return metas;
}

NamedFiles reader_of(FolderFiles& folder) {
  return [&folder](const std::string& file, std::uint64_t max_bytes) {
    return folder.read(file, max_bytes);
  };
}

/// Reads the scenes that `find` finds, given the files of the folder.
template <class Find>
Expected<SceneFile> read_folder(const char* format, std::size_t bytes,
                                const std::filesystem::path& path, const Find& find) {
  const std::string name = path.string();
  return within_memory(name, [&]() -> Expected<SceneFile> {
    FolderFiles folder(path.parent_path());
    AttributeBits bits;
    const NamedFiles files = counted(reader_of(folder), bits);
    const auto found = find(files, name);
    if (!found) return std::unexpected(found.error());
    return read_whole(name, [&](SplatSink& sink) -> Expected<SceneFile> {
      SceneFile scene;
      if (auto done = decode_all(*found, files, name, sink, scene); !done)
        return std::unexpected(done.error());
      describe(format, announced_by(*found).first - scene.dropped, bytes + folder.bytes(),
               std::move(bits), scene);
      return scene;
    });
  });
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
    AttributeBits bits;
    const NamedFiles files = counted(once(reader_of(*archive), name), bits);
    const auto found = archive_metas(*archive, files, bytes.size(), name);
    if (!found) return std::unexpected(found.error());
    SceneFile scene;
    if (auto done = decode_all(*found, files, name, sink, scene); !done)
      return std::unexpected(done.error());
    describe("sog", announced_by(*found).first - scene.dropped, bytes.size(), std::move(bits),
             scene);
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
    const auto found = archive_metas(*archive, once(reader_of(*archive), name), bytes.size(), name);
    if (!found) return std::unexpected(found.error());
    return announced_by(*found);
  });
}

bool is_sog_meta(std::span<const std::byte> bytes) {
  return is_object_with(bytes, {"\"means\"", "\"quats\"", "\"scales\""});
}

Expected<SceneFile> read_sog_folder(std::span<const std::byte> bytes,
                                    const std::filesystem::path& path) {
  return read_folder(
      "sog-folder", bytes.size(), path,
      [&](const NamedFiles&, const std::string& name) { return located_meta(bytes, "", name); });
}

bool is_sog_lod(std::span<const std::byte> bytes) {
  return is_object_with(bytes, {"\"lodLevels\"", "\"filenames\"", "\"tree\""});
}

Expected<SceneFile> read_sog_lod(std::span<const std::byte> bytes,
                                 const std::filesystem::path& path) {
  return read_folder("sog-lod", bytes.size(), path,
                     [&](const NamedFiles& files, const std::string& name) {
                       return finest_chunks(bytes, files, "", name);
                     });
}

}  // namespace fluxgs
