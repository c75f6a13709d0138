// Finds the folder of a data set from a path near it.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"

namespace fluxgs {

/// The folder that was meant: that of a transforms.json, or the only one with poses up to three
/// levels below one with hardly any photos. Otherwise `given`. Errors: several data
/// sets lie below; they are named.
Expected<std::filesystem::path> meant_folder(const std::filesystem::path& given);

}  // namespace fluxgs
