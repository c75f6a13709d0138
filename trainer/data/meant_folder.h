// The folder of a data set that somebody means who names one near it.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"

namespace fluxgs {

/// True for a folder with a COLMAP model (itself or in sparse/) or a transforms.json.
bool holds_poses(const std::filesystem::path& folder);

/// The folder that was meant: that of a transforms.json, the one above images/ that has the poses,
/// or the only one with poses up to three levels below. Otherwise `given`. Errors: several data
/// sets lie below; they are named.
Expected<std::filesystem::path> meant_folder(const std::filesystem::path& given);

}  // namespace fluxgs
