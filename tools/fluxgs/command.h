// What the sub-commands share.
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/error.h"
#include "fluxgs/io/scene.h"

namespace fluxgs::cli {

/// Work to do once the command line has been read. An error ends the program with exit status 1
/// and one line, "fluxgs: error: WHERE: WHAT".
using Action = std::function<Expected<void>()>;

/// Each adds its sub-command to the program and stores its work in `action` when chosen.
void add_train(CLI::App& app, Action& action);
void add_eval(CLI::App& app, Action& action);
void add_render(CLI::App& app, Action& action);
void add_bench(CLI::App& app, Action& action);
void add_convert(CLI::App& app, Action& action);
void add_info(CLI::App& app, Action& action);
void add_report(CLI::App& app, Action& action);
void add_view(CLI::App& app, Action& action);
void add_doctor(CLI::App& app, Action& action);

/// For options: a number from `least` to `most`, and, unlike with CLI::Range, never NaN.
CLI::Validator in_range(double least, double most);

/// Reads a scene; warns of splats that were left out and of a scene without any.
Expected<SceneFile> load_scene(const std::string& path);

/// Warns if the format does not store all degrees of a scene that goes to `path`.
void warn_of_lost_degrees(const std::string& path, const SceneFormat& format, int sh_degree);

/// Results go to standard output: exactly one JSON object with --json.
void print_json(const nlohmann::json& object);

/// Writes a JSON report, whole or not at all.
Expected<void> write_json(const std::string& path, const nlohmann::json& object);

}  // namespace fluxgs::cli
