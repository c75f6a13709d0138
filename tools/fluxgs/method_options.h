// The constants and choices of the method as options of a sub-command.
#pragma once

#include <functional>
#include <vector>

#include <CLI/CLI.hpp>

#include "trainer/model/options.h"

namespace fluxgs::cli {

/// What was given on the command line, to be applied to a preset.
using MethodOptions = std::vector<std::function<void(TrainOptions&)>>;

/// One option for each of option_fields(); its help shows the default of the default preset.
/// `given` must outlive the parsing.
void add_method_options(CLI::App& command, MethodOptions& given);

void apply(const MethodOptions& given, TrainOptions& options);

}  // namespace fluxgs::cli
