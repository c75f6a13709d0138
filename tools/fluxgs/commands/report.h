// Reports of speed or size against error: a table, a JSON and a plot.
#pragma once

#include <string>

#include "fluxgs/error.h"
#include "tools/fluxgs/commands/command.h"

namespace fluxgs::cli {

/// Checks that a chart and a JSON can be written to these paths, each of which may be empty, before
/// minutes are spent on what they shall hold: the folders exist, and what check_plot() asks for.
Expected<void> check_report_outputs(const std::string& plot, const std::string& json);

void add_report_codec(CLI::App& app, Action& action);
void add_report_render(CLI::App& app, Action& action);
void add_report_phone(CLI::App& app, Action& action);
void add_report_sizes(CLI::App& app, Action& action);

}  // namespace fluxgs::cli
