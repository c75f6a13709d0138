// The scene file for a path that may be a folder.
#pragma once

#include <string>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// The path itself, or the meta.json or lod-meta.json in a folder of SOG. Other folders are an
/// error that names the scenes below them, or `fluxgs train` for photos.
Expected<std::string> meant_scene(const std::string& path);

}  // namespace fluxgs::cli
