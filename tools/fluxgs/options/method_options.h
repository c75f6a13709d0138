// The options of a training as options of a sub-command.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "trainer/model/options.h"

namespace fluxgs::cli {

/// Names (without dashes) and values as typed, to be applied to a preset.
using MethodOptions = std::vector<std::pair<std::string, std::string>>;

/// Heading of the options that --help shows; the others are under the names of their phases, which
/// only --help-all shows.
inline constexpr const char* kCommonOptions = "Training";

/// One option for each field of the default preset, whose values the help shows. Values are checked
/// while parsing. `given` must outlive the parsing.
void add_method_options(CLI::App& command, MethodOptions& given);

/// The words of a command line, where a switch that neither "on" nor "off" follows gets "=on":
/// "--antialias photos" becomes "--antialias=on photos".
std::vector<std::string> with_switches_on(std::vector<std::string> words);

/// Lets --help show these groups of options only, and --help-all all of them.
void show_groups(CLI::App& command, std::vector<std::string> groups);

/// The options whose values would change by apply(), with the values that they have.
MethodOptions changed_options(const MethodOptions& given, const TrainOptions& options);

/// Sets the options, which have been checked.
void apply(const MethodOptions& given, TrainOptions& options);

}  // namespace fluxgs::cli
