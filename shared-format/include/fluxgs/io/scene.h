// Scenes of any format: the format of a file read is found by its content, that of a file written
// by the end of its name. A new format is one more file and one more row of the table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/byte_source.h"
#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"
#include "fluxgs/io/write_options.h"

namespace fluxgs {

/// Part of a scene's screen filter that a format keeps.
enum class StoredFilter {
  none,          ///< comes back as that of classic 3DGS
  compensation,  ///< on or off; the dilation comes back as 0.3 px²
  all,
};

/// A row of the table of formats.
struct SceneFormat {
  std::string_view name;         ///< as `fluxgs info` prints it
  std::string_view description;  ///< for people
  std::string_view extension;    ///< end of a file's name, lower case, with the dot
  int max_sh_degree;             ///< highest degree it stores; a writer leaves out the rest
  StoredFilter stored_filter;    ///< for its writer; readers may find less
  /// True if the content looks like this format.
  bool (*recognises)(std::span<const std::byte> bytes);
  /// Gives the splats to the sink, not into the result. Null for a format of several files.
  Expected<SceneFile> (*read)(const ByteSource& source, const std::string& name, SplatSink& sink);
  /// Its reader holds parts of the file only; others may take all of it into memory.
  bool reads_parts;
  /// Null for a format that is only read.
  Expected<std::vector<std::byte>> (*encode)(const SplatCloud& cloud, const std::string& name,
                                             const WriteOptions& options);
  /// For a format of several files: reads them, given the content of the first and where it lies.
  Expected<SceneFile> (*read_with_folder)(std::span<const std::byte> bytes,
                                          const std::filesystem::path& path) = nullptr;
  /// For a writer that reorders a finite cloud: the indices of its splats as they lie in the file.
  std::vector<std::uint32_t> (*order)(const SplatCloud& cloud) = nullptr;

  /// True if a scene with this filter comes back with it.
  bool stores(const ScreenFilter& filter) const;
};

/// All formats, in the order in which a content is offered to them.
std::span<const SceneFormat> scene_formats();

/// The extensions that can be written: ".ply, .glb, ...".
std::string writable_extensions();

/// The format of a content. Fails on what is no scene, and on one that names other files.
Expected<const SceneFormat*> recognise_scene(std::span<const std::byte> bytes,
                                             const std::string& name);
/// The same of the first bytes of a file, which should be thousands.
Expected<const SceneFormat*> recognise_beginning(std::span<const std::byte> begin,
                                                 const std::string& name);

/// Read a scene from memory; `name` appears in errors. A scene of several files is an error.
Expected<SceneFile> read_scene(std::span<const std::byte> bytes, const std::string& name);

/// Read a scene that need not be in memory; its splats go to the sink, not into the result.
/// `format` is that of recognise_scene() or recognise_beginning().
Expected<SceneFile> read_scene(const SceneFormat& format, const ByteSource& source,
                               const std::string& name, SplatSink& sink);

/// Read a scene from a file, and from others of its folder if its format has several.
Expected<SceneFile> read_scene(const std::filesystem::path& path);

/// Write a scene under its final name, whole or not at all. An extension that is unknown, or of
/// a format that is only read, is an error that lists those that can be written.
Expected<void> write_scene(const std::filesystem::path& path, const SplatCloud& cloud,
                           const WriteOptions& options = {});

/// The format that write_scene would choose: for checking a name before long work.
Expected<const SceneFormat*> scene_format_for(const std::filesystem::path& path);

}  // namespace fluxgs
