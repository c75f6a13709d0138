// What the reports share: speed or size against error, as a table, a JSON and a plot.
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/error.h"
#include "tools/fluxgs/command.h"

namespace fluxgs::cli {

/// JSON has no infinity.
nlohmann::json finite_or_null(double value);

/// Whether a chart and a JSON can be written to these paths, each of which may be empty, before
/// minutes are spent on what they shall hold: the folders exist, and what check_plot() asks for.
Expected<void> check_outputs(const std::string& plot, const std::string& json);

/// Writes the numbers to a file and the table to standard output, or the numbers alone to standard
/// output for "-", or the table alone for "".
Expected<void> give_report(const std::string& path, const nlohmann::json& numbers,
                           const std::function<void()>& print_table);

void add_report_codec(CLI::App& app, Action& action);
void add_report_render(CLI::App& app, Action& action);
void add_report_train(CLI::App& app, Action& action);
void add_report_phone(CLI::App& app, Action& action);

}  // namespace fluxgs::cli
