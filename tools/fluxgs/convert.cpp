// fluxgs convert: from one scene format to another.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/file.h"
#include "tools/fluxgs/command.h"

namespace fluxgs::cli {
namespace {

struct ConvertSettings {
  std::string in, out;
  bool compact = false, plain_attributes = false;
  double coarseness = 1;
};

Expected<std::size_t> write_compact(const ConvertSettings& settings, const SplatCloud& cloud) {
  const CompactOptions options{usual_compact_steps(cloud, settings.coarseness),
                               settings.plain_attributes};
  const auto bytes = encode_compact_glb(cloud, options, settings.out);
  if (!bytes) return std::unexpected(bytes.error());
  if (auto written = write_file_atomic(settings.out, *bytes); !written)
    return std::unexpected(written.error());
  return bytes->size();
}

Expected<void> convert(const ConvertSettings& settings) {
  const auto format = scene_format_for(settings.out);
  if (!format) return std::unexpected(format.error());
  if (settings.compact && (*format)->name != "glb")
    return fail(settings.out, "--compact", "expected a name that ends in .glb");
  const auto scene = load_scene(settings.in);
  if (!scene) return std::unexpected(scene.error());
  warn_of_lost_degrees(settings.out, **format, scene->cloud.sh_degree);
  if (settings.compact) {
    const auto bytes = write_compact(settings, scene->cloud);
    if (!bytes) return std::unexpected(bytes.error());
    spdlog::info("{}: {} splats, {} bytes", settings.out, scene->cloud.size(), *bytes);
    return {};
  }
  if (auto written = write_scene(settings.out, scene->cloud); !written) return written;
  spdlog::info("{}: {} splats", settings.out, scene->cloud.size());
  return {};
}

}  // namespace

void add_convert(CLI::App& app, Action& action) {
  auto settings = std::make_shared<ConvertSettings>();
  CLI::App* command = app.add_subcommand("convert", "Rewrite a scene in another format");
  command->footer(
      "The format read is found by content, the one written by the file's name.\n"
      "Example: fluxgs convert garden.ply garden.glb --compact");
  command->add_option("in", settings->in, "the scene to read")->required();
  command->add_option("out", settings->out, "the scene to write: " + writable_extensions())
      ->required();
  CLI::Option* compact =
      command->add_flag("--compact", settings->compact,
                        "write a compact .glb: a fraction of the bytes, with a small error");
  command
      ->add_option("--coarseness", settings->coarseness,
                   "of the compact .glb: 0.5 is finer, 2 smaller")
      ->check(CLI::Range(0.001, 1000.0))
      ->capture_default_str()
      ->needs(compact);
  command
      ->add_flag("--plain-attributes", settings->plain_attributes,
                 "store the compact splats as plain floats too, for other viewers")
      ->needs(compact);
  command->callback([=, &action] { action = [=] { return convert(*settings); }; });
}

}  // namespace fluxgs::cli
