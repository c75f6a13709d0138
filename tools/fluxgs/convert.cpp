// fluxgs convert: from one scene format to another.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "tools/fluxgs/command.h"

namespace fluxgs::cli {
namespace {

Expected<void> convert(const std::string& in, const std::string& out) {
  const auto format = scene_format_for(out);
  if (!format) return std::unexpected(format.error());
  const auto scene = load_scene(in);
  if (!scene) return std::unexpected(scene.error());
  warn_of_lost_degrees(out, **format, scene->cloud.sh_degree);
  if (auto written = write_scene(out, scene->cloud); !written) return written;
  spdlog::info("{}: {} splats", out, scene->cloud.size());
  return {};
}

}  // namespace

void add_convert(CLI::App& app, Action& action) {
  auto in = std::make_shared<std::string>(), out = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("convert", "Rewrite a scene in another format");
  command->footer(
      "The format read is found by content, the one written by the file's name.\n"
      "Example: fluxgs convert garden.ply garden.glb");
  command->add_option("in", *in, "the scene to read")->required();
  command->add_option("out", *out, "the scene to write: " + writable_extensions())->required();
  command->callback([=, &action] { action = [=] { return convert(*in, *out); }; });
}

}  // namespace fluxgs::cli
