// What every scene reader returns.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// A scene as read, with what `fluxgs info` says about it.
struct SceneFile {
  SplatCloud cloud;                     ///< finite splats only
  std::string format;                   ///< name of the format, see scene_formats()
  std::vector<std::string> extensions;  ///< glTF: extensionsUsed
  std::size_t dropped = 0;              ///< splats left out for a NaN or infinity
  std::size_t bytes = 0;                ///< size of the file
};

/// Bytes that `count` splats take in a SplatCloud. Readers hold at most the file plus this much
/// (plus a bounded amount for a header).
constexpr std::size_t splat_memory_bytes(std::size_t count, int sh_degree) {
  return count * sizeof(float) * static_cast<std::size_t>(14 + 3 * sh_rest_count(sh_degree));
}

}  // namespace fluxgs
