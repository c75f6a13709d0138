// JSON files that this program wrote, read again.
#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// The value in a file. Errors: cannot be read, no JSON.
Expected<nlohmann::json> read_json(const std::filesystem::path& path);

}  // namespace fluxgs::cli
