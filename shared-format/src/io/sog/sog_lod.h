// lod-meta.json of a streamed SOG scene (PlayCanvas, "The Streamed SOG Format", version 1).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// A file with splats of the finest level: an unbundled SOG scene.
struct SogChunk {
  std::string file;       ///< plain name of its meta.json
  std::size_t count = 0;  ///< splats that the tree expects in it
};

/// The chunks of level 0 in the order of `filenames`. By section 3.2 the runs of the tree's leaves
/// cover a chunk without overlap, so that the chunk as a whole is what they select.
Expected<std::vector<SogChunk>> parse_sog_lod(const nlohmann::json& root, const std::string& name);

}  // namespace fluxgs::io
