// Reports of speed or size against error: a table, a JSON and a plot.
#pragma once

#include <functional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "fluxgs/error.h"
#include "tools/fluxgs/commands/command.h"

namespace fluxgs::cli {

/// Whether a chart and a JSON can be written to these paths, each of which may be empty, before
/// minutes are spent on what they shall hold: the folders exist, and what check_plot() asks for.
Expected<void> check_outputs(const std::string& plot, const std::string& json);

/// Writes the numbers to a file and the table to standard output, or the numbers alone to standard
/// output for "-", or the table alone for "".
Expected<void> give_report(const std::string& path, const nlohmann::json& numbers,
                           const std::function<void()>& print_table);

void add_report_codec(CLI::App& app, Action& action);
void add_report_render(CLI::App& app, Action& action);
void add_report_phone(CLI::App& app, Action& action);

}  // namespace fluxgs::cli
