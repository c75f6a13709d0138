// The sub-commands, and scene files read and written for them.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/io/scene.h"

namespace CLI {
class App;
}

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
void add_web(CLI::App& app, Action& action);
void add_doctor(CLI::App& app, Action& action);

/// The words of a command line as the sub-commands take them: "help train" is "train --help", and
/// "train --antialias DATA" is "train --antialias=on DATA".
std::vector<std::string> plain_words(std::vector<std::string> words);

/// The switch that a word follows in such words, "--antialias" before "maybe"; empty if none.
std::string switch_before(const std::vector<std::string>& words, const std::string& word);

/// Reads a scene file or folder (meant_scene.h), or the scene of a checkpoint of fluxgs train.
Expected<SceneFile> read_scene_or_checkpoint(const std::string& given);

/// Prints the reader's warnings, and warns of splats that were left out and of a scene without
/// any.
void warn_of(const std::string& path, const SceneFile& scene);

/// read_scene_or_checkpoint() and warn_of().
Expected<SceneFile> load_scene(const std::string& path);

/// Warns if the format does not store all degrees of a scene that goes to `path`.
void warn_of_lost_degrees(const std::string& path, const SceneFormat& format, int sh_degree);

/// Writes a .glb, with an initial view if there is one. Returns the bytes of the file.
Expected<std::size_t> write_glb(const std::string& path, const std::vector<std::byte>& glb,
                                const std::optional<InitialView>& initial);

}  // namespace fluxgs::cli
