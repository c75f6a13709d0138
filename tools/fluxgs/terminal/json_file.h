// JSON reports: to standard output and to files, and read again.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// Prints one JSON object to standard output.
void print_json(const nlohmann::json& object);

/// Writes a JSON report, whole or not at all.
Expected<void> write_json(const std::string& path, const nlohmann::json& object);

/// Gives a report to standard output alone for "-"; otherwise prints its table and, unless `path`
/// is empty, writes it to a file.
Expected<void> give_report(const std::string& path, const nlohmann::json& report,
                           const std::function<void()>& print_table);

/// The value in a file. Errors: cannot be read, not JSON.
Expected<nlohmann::json> read_json(const std::filesystem::path& path);

/// JSON has no infinity: null instead.
nlohmann::json finite_or_null(double value);

}  // namespace fluxgs::cli
