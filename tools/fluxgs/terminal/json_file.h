// JSON reports: to standard output and to files, and read again.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// Prints one JSON object to standard output.
void print_json(const nlohmann::json& object);

/// Writes a JSON report, whole or not at all.
Expected<void> write_json(const std::string& path, const nlohmann::json& object);

/// The value in a file. Errors: cannot be read, not JSON.
Expected<nlohmann::json> read_json(const std::filesystem::path& path);

/// JSON has no infinity: null instead.
nlohmann::json finite_or_null(double value);

}  // namespace fluxgs::cli
