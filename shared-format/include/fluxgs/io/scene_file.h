// A scene as every reader returns it.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fluxgs/io/initial_view.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// Bits that the file spends on each attribute of a splat, by name: position, scale, rotation,
/// opacity, sh_dc, sh_rest, and what else a format has (tables shared by many splats count in parts
/// of a bit).
using AttributeBits = std::map<std::string, double>;

/// A part of a file whose splats lie in the order of what they add to images.
struct SceneChunk {
  std::size_t splats = 0;  ///< those with a NaN or infinity included
  std::size_t end = 0;     ///< so many of the file's first bytes hold this and all chunks before
};

/// A scene as read, with what `fluxgs info` says about it.
struct SceneFile {
  SplatCloud cloud;                     ///< finite splats only
  std::string format;                   ///< name of the format, see scene_formats()
  std::vector<std::string> extensions;  ///< glTF: extensionsUsed
  std::size_t dropped = 0;              ///< splats left out for a NaN or infinity
  /// Warnings of the reader for people, a sentence each, without the file's name: "its last record
  /// is cut off; the 119 whole ones are read"
  std::vector<std::string> warnings;
  AttributeBits attribute_bits;      ///< see above
  std::size_t bytes = 0;             ///< size of the file
  std::optional<InitialView> start;  ///< the start view that the file names
  std::vector<SceneChunk> chunks;    ///< none where all splats come at once
};

/// The bits of a format that stores plain 32-bit floats.
inline AttributeBits float_attribute_bits(int sh_degree) {
  AttributeBits bits{
      {"position", 96}, {"scale", 96}, {"rotation", 128}, {"opacity", 32}, {"sh_dc", 96}};
  if (sh_degree > 0) bits["sh_rest"] = 96 * sh_rest_count(sh_degree);
  return bits;
}

/// Bytes that `count` splats take in a SplatCloud. Readers hold at most the file plus this much
/// (plus a bounded amount for a header).
constexpr std::size_t splat_memory_bytes(std::size_t count, int sh_degree) {
  return count * sizeof(float) * static_cast<std::size_t>(14 + 3 * sh_rest_count(sh_degree));
}

}  // namespace fluxgs
