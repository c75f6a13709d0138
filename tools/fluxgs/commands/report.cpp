// fluxgs report: speed or size against error, for each setting.
#include "tools/fluxgs/commands/report.h"

#include <filesystem>
#include <system_error>

#include <CLI/CLI.hpp>

#include "tools/fluxgs/commands/plot.h"

namespace fluxgs::cli {

Expected<void> check_report_outputs(const std::string& plot, const std::string& json) {
  for (const std::string& path : {plot, json}) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
      return fail(path, "", "its folder does not exist");
  }
  return plot.empty() ? Expected<void>() : check_plot(plot);
}

void add_report(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("report", "Tables and plots of size or speed against error");
  command->require_subcommand(1);
  command->footer("Example: fluxgs report codec garden.ply --plot codec.png");
  add_report_codec(*command, action);
  add_report_render(*command, action);
  add_report_phone(*command, action);
  add_report_sizes(*command, action);
}

}  // namespace fluxgs::cli
