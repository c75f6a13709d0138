// fluxgs convert: from one scene format to another.
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/file.h"
#include "fluxgs/sanitize.h"
#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/view_sensitivity.h"

namespace fluxgs::cli {
namespace {

struct ConvertSettings {
  std::string in, out;
  bool compact = false, plain_attributes = false;
  double step_scale = 1;
  int sh_degree = 3, spz_version = 3;
  std::optional<std::size_t> max_bytes;
  std::optional<double> min_psnr;
  DataOptions data;

  bool searches() const { return max_bytes || min_psnr; }
};

std::string shown(const std::string& path) { return one_line(path, std::string::npos); }

/// A splat far from all others, or splats much smaller than the scene, leave few steps for each.
void warn_of_outliers(const ConvertSettings& s, const SplatCloud& cloud) {
  const double step = default_quantization_steps(cloud).position;
  if (cloud.size() > 0 && step <= finest_position_step(cloud))
    spdlog::warn(
        "warning: {}: the scene is so much larger than its splats that positions are rounded to "
        "{:.3g}",
        s.in, step);
}

Expected<void> write_compact(const ConvertSettings& s, const SceneFile& scene) {
  const SplatCloud& cloud = scene.cloud;
  const CompactOptions options{default_quantization_steps(cloud, s.step_scale), s.plain_attributes};
  const auto bytes = encode_compact_glb(cloud, options, s.out);
  if (!bytes) return std::unexpected(bytes.error());
  const auto written = write_glb(s.out, *bytes, scene.start);
  if (!written) return std::unexpected(written.error());
  fmt::print("{}: {} splats, {} bytes\n", shown(s.out), cloud.size(), *written);
  return {};
}

WriteOptions write_options(const ConvertSettings& s) {
  WriteOptions options;
  options.spz_version = s.spz_version;
  options.warn = [out = s.out](const std::string& text) {
    spdlog::warn("warning: {}: {}", out, text);
  };
  const ProgressReport report = show_progress("%");
  options.progress = [report](double part) {
    report(static_cast<std::size_t>(std::lround(100 * part)), 100);
  };
  return options;
}

/// Only a .glb says where it is looked at from.
Expected<void> write_plain(const ConvertSettings& s, const SceneFile& scene,
                           const SceneFormat& format) {
  const WriteOptions options = write_options(s);
  if (format.name != "glb") return write_scene(s.out, scene.cloud, options);
  const auto bytes = format.encode(scene.cloud, s.out, options);
  if (!bytes) return std::unexpected(bytes.error());
  if (auto written = write_glb(s.out, *bytes, scene.start); !written)
    return std::unexpected(written.error());
  return {};
}

/// Bytes of --max-bytes that are left for the splats.
std::size_t max_bytes(const ConvertSettings& s, const SceneFile& scene) {
  const std::size_t start = scene.start ? kMaxInitialViewBytes : 0;
  return *s.max_bytes - std::min(start, *s.max_bytes - 1);
}

Expected<CompactTrial> search(const ConvertSettings& s, const SceneFile& scene) {
  const SplatCloud& cloud = scene.cloud;
  const auto loaded = load_if_given(s.data);
  if (!loaded) return std::unexpected(loaded.error());
  const Dataset* data = *loaded ? &**loaded : nullptr;
  const Threads threads(s.data.threads);
  RenderOptions options;
  options.background = s.data.background_color();
  const std::vector<Camera> cameras = evaluation_cameras(cloud, data);
  const SceneError error(cloud, cameras, options, threads);
  Progress progress("trials", CompactSearch::kDefaultTrials, 0);
  int trials = 0;
  CompactOptions start{default_quantization_steps(cloud), s.plain_attributes};
  if (data != nullptr)
    start.sensitivity = view_sensitivity(cameras_of(data->train), cloud, false, options, threads,
                                         show_progress("views"));
  const CompactSearch search(cloud, error, start, [&](const CompactTrial& t) {
    progress.update(++trials, fmt::format("{} bytes  {}", t.file.size(), decibels(t.psnr())));
  });
  auto found =
      s.max_bytes ? search.within_bytes(max_bytes(s, scene)) : search.within_loss(*s.min_psnr);
  progress.clear();
  if (!found) return fail(s.out, found.error().field, found.error().what);
  return found;
}

Expected<void> write_searched(const ConvertSettings& s, const SceneFile& scene, int full_degree) {
  const SplatCloud& cloud = scene.cloud;
  if (cloud.size() == 0) return write_compact(s, scene);
  const auto found = search(s, scene);
  if (!found) return std::unexpected(found.error());
  const auto bytes = write_glb(s.out, found->file, scene.start);
  if (!bytes) return std::unexpected(bytes.error());
  const std::string error =
      found->mse > 0 ? fmt::format("{:.2f} dB from", found->psnr()) : "exactly";
  fmt::print("{}: {} splats, {} bytes, {} the images of {}{}\n", shown(s.out), cloud.size(), *bytes,
             error, shown(s.in),
             cloud.sh_degree < full_degree ? fmt::format(" at degree {}", cloud.sh_degree) : "");
  return {};
}

Expected<void> convert(const ConvertSettings& s) {
  const auto format = scene_format_for(s.out);
  if (!format) return std::unexpected(format.error());
  const bool compact = s.compact || s.searches();
  if (compact && (*format)->name != "glb")
    return fail(s.out, "extension", "expected .glb, which a compact scene is written as");
  auto scene = load_scene(s.in);
  if (!scene) return std::unexpected(scene.error());
  const int full_degree = scene->cloud.sh_degree;
  limit_sh_degree(scene->cloud, s.sh_degree);
  warn_of_lost_degrees(s.out, **format, scene->cloud.sh_degree);
  if (compact) warn_of_outliers(s, scene->cloud);
  if (s.searches()) return write_searched(s, *scene, full_degree);
  if (compact) return write_compact(s, *scene);
  if (auto written = write_plain(s, *scene, **format); !written) return written;
  fmt::print("{}: {} splats\n", shown(s.out), scene->cloud.size());
  return {};
}

/// Refuses options that would do nothing.
void check_use(const ConvertSettings& s, const CLI::App& command) {
  for (const char* option : {"--threads", "--background"})
    if (command.count(option) > 0 && !s.searches())
      throw CLI::ValidationError(option, "is used only by --min-psnr and --max-bytes");
  if (command.count("--downscale") > 0 && s.data.folder.empty())
    throw CLI::ValidationError("--downscale", "is used only with --data");
  if (!s.data.folder.empty() && !s.searches())
    throw CLI::ValidationError("--data", "is used only by --min-psnr and --max-bytes");
  if (s.plain_attributes && !s.compact && !s.searches())
    throw CLI::ValidationError("--plain-attributes",
                               "is used only with --compact, --min-psnr or --max-bytes");
}

void add_compact_options(CLI::App& command, ConvertSettings& s) {
  const std::string group = "Compact .glb";
  CLI::Option* compact = command.add_flag(
      "--compact", s.compact, "write a compact file: a fraction of the bytes, with a small error");
  CLI::Option* step_scale = command.add_option(
      "--step-scale", s.step_scale,
      "with --compact: factor of the quantization steps; 0.5 is finer, 2 is smaller");
  step_scale->check(in_range(0.001, 1000))->capture_default_str()->needs(compact);
  CLI::Option* bytes = command.add_option("--max-bytes", s.max_bytes,
                                          "search for the least error in a file of this size");
  bytes->check(CLI::Range(std::size_t{1}, std::size_t{1} << 50));
  CLI::Option* loss = command.add_option(
      "--min-psnr", s.min_psnr, "search for the smallest file whose renders have this PSNR (dB)");
  loss->check(in_range(1, 120))->excludes(bytes)->excludes(step_scale);
  bytes->excludes(step_scale);
  CLI::Option* plain =
      command.add_flag("--plain-attributes", s.plain_attributes,
                       "also store plain floats: a large file that other viewers open");
  CLI::Option* data = command.add_option(
      "--data", s.data.folder, "measure PSNR on the views of this data set instead of an orbit");
  for (CLI::Option* option : {compact, step_scale, bytes, loss, plain, data}) option->group(group);
}

}  // namespace

void add_convert(CLI::App& app, Action& action) {
  auto settings = std::make_shared<ConvertSettings>();
  CLI::App* command = app.add_subcommand("convert", "Convert a scene to another format");
  command->footer(
      "The content of IN tells its format, the name of OUT the other. PSNR is measured on twelve\n"
      "views, against the scene with the SH coefficients that are kept.\n"
      "Example: fluxgs convert garden.ply garden.glb --min-psnr 40");
  command->add_option("in", settings->in, "the scene to read")->required();
  command->add_option("out", settings->out, "the scene to write: " + writable_extensions())
      ->required();
  command->add_option("--sh-degree", settings->sh_degree, "highest SH degree to keep")
      ->check(CLI::Range(0, 3))
      ->capture_default_str();
  command
      ->add_option("--spz-version", settings->spz_version,
                   "version of a .spz: 3, read everywhere, or 4, smaller")
      ->check(CLI::Range(3, 4))
      ->capture_default_str();
  add_compact_options(*command, *settings);
  add_data_options(*command, settings->data);
  command->callback([=, &action] {
    check_use(*settings, *command);
    action = [=] { return convert(*settings); };
  });
}

}  // namespace fluxgs::cli
