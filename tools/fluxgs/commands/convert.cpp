// fluxgs convert: from one scene format to another.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/stray_splats.h"
#include "fluxgs/sanitize.h"
#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/conversion_losses.h"
#include "tools/fluxgs/commands/inner_box.h"
#include "tools/fluxgs/commands/least_size.h"
#include "tools/fluxgs/commands/scene_crop.h"
#include "tools/fluxgs/commands/scene_map.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/files.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/scene_reduction.h"
#include "trainer/compress/size_search.h"
#include "trainer/compress/view_sensitivity.h"

namespace fluxgs::cli {
namespace {

struct ConvertSettings {
  std::string in, out;
  bool compact = false, no_compact = false, plain_attributes = false, no_chunks = false,
       force = false;
  GlbOptions glb;
  CropOptions crop;
  MapOptions map;
  double step_scale = 1;
  int sh_degree = 3, spz_version = 3;
  std::optional<std::size_t> max_splats, max_bytes;
  std::optional<double> min_psnr;
  DataOptions data;

  bool searches() const { return max_bytes || min_psnr; }
};

std::string shown(const std::string& path) { return one_line(path, std::string::npos); }

/// Splats far from all others, or much smaller than the scene, leave few steps for each.
void warn_of_outliers(const ConvertSettings& s, const SplatCloud& cloud) {
  const double step = default_quantization_steps(cloud).position;
  if (cloud.size() == 0 || step > finest_position_step(cloud)) return;
  const Box most = inner_box(cloud);
  const double extent = step * 0x1p23;  // along an axis
  const bool has_far_splats = extent > 10 * glm::distance(most.min, most.max);
  spdlog::warn(
      "warning: {}: most splats are so much smaller than the scene that positions are rounded to "
      "{:.3g}, more coarsely than their size asks for{}",
      shown(s.in), step,
      has_far_splats ? "; --crop or --crop-sphere leaves out what is far away" : "");
}

/// Limits sizes that no image shows, since those of others would be rounded coarsely.
void limit_sizes(const ConvertSettings& s, SplatCloud& cloud) {
  if (const std::size_t limited = limit_stray_sizes(cloud); limited > 0)
    spdlog::warn(
        "warning: {}: {} of {} splats are so much larger than most that those would be rounded "
        "coarsely; their size is limited",
        shown(s.in), limited, cloud.size());
}

/// Moves a few splats nearer that lie so far away that the steps of all positions would be coarse.
void pull_in_stray(const ConvertSettings& s, double extent, SplatCloud& cloud) {
  const std::size_t moved = extent > 0 ? pull_in_stray_splats(cloud, extent) : 0;
  if (moved > 0)
    spdlog::warn(
        "warning: {}: {} of {} splats lie so far away that the positions of others would be "
        "rounded coarsely; they are moved nearer and made as much smaller (--crop leaves them out)",
        shown(s.in), moved, cloud.size());
}

/// Limits a few colours so strong that those of all others would be coarse.
void limit_colors(const ConvertSettings& s, SplatCloud& cloud) {
  if (const std::size_t limited = limit_stray_colors(cloud); limited > 0)
    spdlog::warn(
        "warning: {}: the colours of {} of {} splats are so much stronger than all others that "
        "those would be rounded coarsely; they are limited",
        shown(s.in), limited, cloud.size());
}

/// Says what the file lost, having read it again.
Expected<void> tell_losses(const ConvertSettings& s, const SceneFile& scene,
                           const std::vector<std::uint32_t>& order) {
  const auto written = read_scene(s.out);
  if (!written) return std::unexpected(written.error());
  for (const std::string& lost : lost_parts(scene, *written))
    spdlog::warn("warning: {}: {}", shown(s.out), lost);
  const RoundingErrors errors = rounding_errors(scene, *written, order);
  if (errors.text.empty()) return {};
  if (errors.lost_shapes > 0)
    spdlog::warn("warning: {}: {}", shown(s.out), errors.text);
  else
    spdlog::info("{}: {}", shown(s.out), errors.text);
  return {};
}

CompactOptions compact_options(const ConvertSettings& s, const SplatCloud& cloud) {
  return {.steps = default_quantization_steps(cloud, s.step_scale),
          .plain_attributes = s.plain_attributes,
          .in_chunks = !s.no_chunks};
}

Expected<void> write_compact(const ConvertSettings& s, const SceneFile& scene) {
  const SplatCloud& cloud = scene.cloud;
  const CompactOptions options = compact_options(s, cloud);
  const auto bytes = encode_compact_glb(cloud, options, s.out);
  if (!bytes) return std::unexpected(bytes.error());
  const auto written = write_glb(s.out, *bytes, scene.start);
  if (!written) return std::unexpected(written.error());
  fmt::print("{}: {} splats, {} bytes{}\n", shown(s.out), cloud.size(), *written,
             cloud.size() > 0 ? ", compact" : "");
  return tell_losses(s, scene, compact_order(cloud, options));
}

WriteOptions write_options(const ConvertSettings& s, const SceneFile& scene) {
  WriteOptions options;
  options.start = scene.start;
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

Expected<void> write_plain(const ConvertSettings& s, const SceneFile& scene,
                           const SceneFormat& format) {
  if (format.name != "glb") return write_scene(s.out, scene.cloud, write_options(s, scene));
  const auto bytes = encode_glb(scene.cloud, s.glb, s.out);
  if (!bytes) return std::unexpected(bytes.error());
  if (auto written = write_glb(s.out, *bytes, scene.start); !written)
    return std::unexpected(written.error());
  return {};
}

/// The splats of a cloud as they lie in a file that is not compact; empty: as they are.
std::vector<std::uint32_t> order_in(const SceneFormat& format, const ConvertSettings& s,
                                    const SplatCloud& cloud) {
  if (format.name == "glb") return glb_order(cloud, s.glb);
  return format.order ? format.order(cloud) : std::vector<std::uint32_t>();
}

ReductionOptions reduction_options(const ConvertSettings& s) {
  ReductionOptions options;
  options.render.background = s.data.background_color();
  return options;
}

/// Leaves no more splats than asked for. PSNR, where it is measured, is then to what is left.
void thin_out(const ConvertSettings& s, const Dataset* data, SceneFile& scene) {
  const std::size_t before = scene.cloud.size();
  if (!s.max_splats || before <= *s.max_splats) return;
  const Threads threads(s.data.threads);
  SceneReduction reduction(scene.cloud, reduction_cameras(scene.cloud, scene.start, data),
                           reduction_options(s), threads);
  reduction.reduce(*s.max_splats, {.progress = show_work("fewer splats")});
  scene.cloud = reduction.cloud();
  spdlog::info("{}: {} of {} splats are left out, those that change images least{}", shown(s.in),
               before - scene.cloud.size(), before,
               data ? "" : "; --data looks at those of a capture");
}

/// The limit of --max-bytes, where one splat and the start view fit into it.
Expected<SizeLimit> size_limit(const ConvertSettings& s, const SceneFile& scene) {
  const auto least = least_size(scene.cloud, scene.start, compact_options(s, scene.cloud));
  if (!least) return std::unexpected(least.error());
  if (least->one_splat <= *s.max_bytes) return SizeLimit{*s.max_bytes, least->start};
  return fail(
      s.out, "size",
      fmt::format("one splat takes {} bytes already, expected {} at most{}", least->one_splat,
                  *s.max_bytes, scene.cloud.sh_degree > 0 ? "; --sh-degree 0 takes less" : ""));
}

/// Number of splats and steps for --max-bytes.
Expected<SizedScene> size_down(const ConvertSettings& s, const SizeLimit& limit,
                               const SceneFile& scene, const Dataset* data, const SceneError& error,
                               const Threads& threads) {
  SceneReduction reduction(scene.cloud, reduction_cameras(scene.cloud, scene.start, data),
                           reduction_options(s), threads);
  auto sized = splats_within_bytes(reduction, error, compact_options(s, scene.cloud), limit,
                                   {.progress = show_work("splats")});
  if (!sized) return fail(s.out, sized.error().field, sized.error().what);
  return sized;
}

/// The steps of a cloud, whose number of splats is settled, for --max-bytes if there is a limit.
Expected<CompactTrial> search_steps(const ConvertSettings& s, const std::optional<SizeLimit>& limit,
                                    const SceneFile& scene, const Dataset* data,
                                    CompactOptions start, const Threads& threads) {
  const RenderOptions options = reduction_options(s).render;
  const SplatCloud& cloud = scene.cloud;
  const SceneError error(cloud, evaluation_cameras(cloud, data), options, threads);
  if (data != nullptr)
    start.sensitivity = view_sensitivity(cameras_of(data->train), cloud, false, options, threads,
                                         {.progress = show_work("views")});
  const CompactSearch search(cloud, error, start, show_work("search"));
  auto found =
      limit ? search.within_bytes(limit->bytes, limit->beside) : search.within_loss(*s.min_psnr);
  if (!found) return fail(s.out, found.error().field, found.error().what);
  return found;
}

/// For --max-bytes `scene` loses splats; the error is to all that it had.
Expected<CompactTrial> search(const ConvertSettings& s, SceneFile& scene, const Dataset* data) {
  const Threads threads(s.data.threads);
  const CompactOptions start = compact_options(s, scene.cloud);
  if (!s.max_bytes) return search_steps(s, std::nullopt, scene, data, start, threads);
  const auto limit = size_limit(s, scene);
  if (!limit) return std::unexpected(limit.error());
  const SceneError error(scene.cloud, evaluation_cameras(scene.cloud, data),
                         reduction_options(s).render, threads);
  auto sized = size_down(s, *limit, scene, data, error, threads);
  if (!sized) return std::unexpected(sized.error());
  scene.cloud = std::move(sized->cloud);
  CompactOptions from = start;
  from.steps = sized->steps;
  auto found = search_steps(s, *limit, scene, data, from, threads);
  if (!found) return found;
  const auto stored = read_scene(found->file, s.out);
  if (!stored) return std::unexpected(stored.error());
  const auto mse = error.mse(stored->cloud);
  if (!mse) return std::unexpected(mse.error());
  found->mse = *mse;
  return found;
}

Expected<void> write_searched(const ConvertSettings& s, SceneFile& scene, const Dataset* data,
                              int full_degree) {
  if (scene.cloud.size() == 0) return write_compact(s, scene);
  const std::size_t before = scene.cloud.size();
  const auto found = search(s, scene, data);
  if (!found) return std::unexpected(found.error());
  const auto bytes = write_glb(s.out, found->file, scene.start);
  if (!bytes) return std::unexpected(bytes.error());
  const SplatCloud& cloud = scene.cloud;
  const std::string error =
      found->mse > 0 ? fmt::format("{:.2f} dB from", found->psnr()) : "exactly";
  const std::string of_all = cloud.size() < before ? fmt::format(" of {}", before) : "";
  fmt::print("{}: {}{} splats, {} bytes, {} the images of {}{}\n", shown(s.out), cloud.size(),
             of_all, *bytes, error, shown(s.in),
             cloud.sh_degree < full_degree ? fmt::format(" at degree {}", cloud.sh_degree) : "");
  return {};
}

bool is_compact(const SceneFile& scene) {
  return std::ranges::find(scene.extensions, kCompactExtension) != scene.extensions.end();
}

/// A compact file stays as it is if nothing about its splats shall change.
Expected<void> copy_compact(const ConvertSettings& s, std::size_t splats) {
  const auto bytes = read_file(s.in);
  if (!bytes) return std::unexpected(bytes.error());
  if (auto written = write_file_atomic(s.out, *bytes); !written) return written;
  fmt::print("{}: {} splats, {} bytes, compact, copied (--no-compact writes floats)\n",
             shown(s.out), splats, bytes->size());
  return {};
}

/// The scene of IN, as much of it as shall be kept.
Expected<SceneFile> load_cropped(const ConvertSettings& s) {
  auto scene = load_scene(s.in);
  if (!scene) return scene;
  const std::size_t left_out = crop_scene(s.crop, scene->cloud);
  if (left_out > 0 && scene->cloud.size() == 0)
    return fail(s.in, "",
                fmt::format("none of its {} splats is within {}; fluxgs info shows where they lie",
                            left_out, limits_of(s.crop)));
  if (left_out > 0) spdlog::info("{}: {} splats are left out", shown(s.in), left_out);
  return scene;
}

Expected<void> write_out(const ConvertSettings& s) {
  const auto format = scene_format_for(s.out);
  if (!format) return std::unexpected(format.error());
  const bool glb = (*format)->name == "glb";
  if ((s.compact || s.searches()) && !glb)
    return fail(s.out, "extension", "expected .glb, which a compact scene is written as");
  if (s.glb.attribute_bits != 32 && !glb)
    return fail(s.out, "extension", "expected .glb, which --quantize-attributes is about");
  auto scene = load_cropped(s);
  if (!scene) return std::unexpected(scene.error());
  const int full_degree = scene->cloud.sh_degree;
  const bool stays_compact =
      glb && is_compact(*scene) && !s.no_compact && s.glb.attribute_bits == 32;
  if (stays_compact && !s.compact && !s.searches() && full_degree <= s.sh_degree &&
      !s.crop.crops() && map_of(s.map) == AffineMap{} &&
      scene->cloud.size() <= s.max_splats.value_or(scene->cloud.size()))
    return copy_compact(s, scene->cloud.size());
  limit_sh_degree(scene->cloud, s.sh_degree);
  const std::size_t size = scene->cloud.size();
  const bool needs_views = size > s.max_splats.value_or(size) || (s.searches() && size > 0);
  const auto loaded =
      needs_views ? load_if_given(s.data) : Expected<std::optional<Dataset>>(std::nullopt);
  if (!loaded) return std::unexpected(loaded.error());
  const Dataset* data = *loaded ? &**loaded : nullptr;
  thin_out(s, data, *scene);
  map_scene(s.map, *scene);
  warn_of_lost_degrees(s.out, **format, scene->cloud.sh_degree);
  const bool compact = s.compact || s.searches() || stays_compact;
  constexpr double kRadii = 40;  // of a chunk of compressed .ply: its step is then 2% of a radius
  if (compact) pull_in_stray(s, largest_fine_extent(scene->cloud, s.step_scale), scene->cloud);
  if ((*format)->name == "compressed.ply")
    pull_in_stray(s, kRadii * median_distance(scene->cloud), scene->cloud);
  if (compact || (*format)->name == "compressed.ply" || (*format)->name == "sog")
    limit_colors(s, scene->cloud);
  if (compact) {
    limit_sizes(s, scene->cloud);
    warn_of_outliers(s, scene->cloud);
  }
  if (s.searches()) return write_searched(s, *scene, data, full_degree);
  if (compact) return write_compact(s, *scene);
  if (auto written = write_plain(s, *scene, **format); !written) return written;
  fmt::print("{}: {} splats\n", shown(s.out), scene->cloud.size());
  return tell_losses(s, *scene, order_in(**format, s, scene->cloud));
}

/// Keeps a file that lay under the name of the result beside it.
Expected<void> convert(const ConvertSettings& s) {
  if (auto ok = check_no_folder(s.out); !ok) return ok;
  const auto kept = s.force ? Expected<std::filesystem::path>() : keep_old(s.out);
  if (!kept) return std::unexpected(kept.error());
  auto done = write_out(s);
  if (kept->empty()) return done;
  std::error_code ignored;
  if (!done)
    std::filesystem::remove(*kept, ignored);
  else
    spdlog::warn("warning: {}: existed, and is kept as {} (--force replaces it)", shown(s.out),
                 kept->filename().string());
  return done;
}

/// Refuses options that would do nothing.
void check_use(const ConvertSettings& s, const CLI::App& command) {
  if (command.count("--background") > 0 && !s.searches() && !s.max_splats)
    throw CLI::ValidationError("--background",
                               "is used only by --max-splats, --min-psnr and --max-bytes");
  if (command.count("--spz-version") > 0 && !s.out.ends_with(".spz"))
    throw CLI::ValidationError("--spz-version", "is used only for a .spz");
  if (command.count("--downscale") > 0 && s.data.folder.empty())
    throw CLI::ValidationError("--downscale", "is used only with --data");
  if (!s.data.folder.empty() && !s.searches() && !s.max_splats)
    throw CLI::ValidationError("--data",
                               "is used only by --max-splats, --min-psnr and --max-bytes");
  for (const char* option : {"--plain-attributes", "--no-chunks"})
    if (command.count(option) > 0 && !s.compact && !s.searches())
      throw CLI::ValidationError(option, "is used only with --compact, --min-psnr or --max-bytes");
  check_crop(s.crop);
}

void add_compact_options(CLI::App& command, ConvertSettings& s) {
  const std::string group = "Compact .glb";
  CLI::Option* compact = command.add_flag(
      "--compact", s.compact, "write a compact file: a fraction of the bytes, with a small error");
  CLI::Option* floats =
      command.add_flag("--no-compact", s.no_compact, "write plain floats, also if IN is compact");
  floats->excludes(compact);
  CLI::Option* step_scale = command.add_option(
      "--step-scale", s.step_scale,
      "with --compact: factor of the quantization steps; 0.5 is finer, 2 is smaller");
  step_scale->check(in_range(0.001, 1000))->capture_default_str()->needs(compact);
  CLI::Option* bytes = command.add_option("--max-bytes", s.max_bytes,
                                          "search for the least error in a file of this size, with "
                                          "fewer splats where that is better");
  bytes->transform(amount_in(1, std::int64_t{1} << 50, "B"));
  CLI::Option* loss = command.add_option(
      "--min-psnr", s.min_psnr, "search for the smallest file whose renders have this PSNR (dB)");
  loss->check(in_range(1, 120))->excludes(bytes)->excludes(step_scale)->excludes(floats);
  bytes->excludes(step_scale)->excludes(floats);
  CLI::Option* plain =
      command.add_flag("--plain-attributes", s.plain_attributes,
                       "also store plain floats: a large file that other viewers open");
  CLI::Option* chunks = command.add_flag(
      "--no-chunks", s.no_chunks, "do not put first what shows most of a scene while it is loaded");
  CLI::Option* data = command.add_option("--data", s.data.folder,
                                         "use the views of this data set instead of an orbit");
  for (CLI::Option* option : {compact, floats, step_scale, bytes, loss, plain, chunks, data})
    option->group(group);
  CLI::Option* quantize = command.add_option(
      "--quantize-attributes", s.glb.attribute_bits,
      "bits of rotations, scales and opacities in a plain .glb: 8, 16 or 32 (floats)");
  quantize->check(CLI::IsMember({8, 16, 32}))->capture_default_str()->group("Plain .glb");
  for (CLI::Option* option : {compact, bytes, loss}) quantize->excludes(option);
}

}  // namespace

void add_convert(CLI::App& app, Action& action) {
  auto settings = std::make_shared<ConvertSettings>();
  CLI::App* command = app.add_subcommand("convert", "Convert a scene to another format");
  command->footer(
      "The content of IN tells its format, the name of OUT the other. PSNR is measured on twelve\n"
      "views, against the scene with the SH coefficients that are kept. A compact .glb stays "
      "compact\n"
      "as a .glb. What a format cannot hold is said in a line each.\n"
      "Example: fluxgs convert garden.ply garden.glb --min-psnr 40\n"
      "         fluxgs convert garden.ply small.glb --max-bytes 500k\n"
      "         fluxgs convert garden.glb upright.glb --up z --scale 0.5\n"
      "         fluxgs convert garden.ply light.glb --max-splats 50k --data captures/garden\n"
      "         fluxgs convert garden.ply table.glb --crop-sphere 0,0.4,2,1.5");
  command->add_option("in", settings->in, "the scene to read")->required();
  command->add_option("out", settings->out, "the scene to write: " + writable_extensions())
      ->required();
  command->add_option("--sh-degree", settings->sh_degree, "highest SH degree to keep")
      ->check(whole_in(0, 3))
      ->capture_default_str();
  command
      ->add_option("--max-splats", settings->max_splats,
                   "keep no more splats than this: those whose removal changes images least go, a "
                   "few at a time, and the others are fitted to the images of IN (from views of "
                   "the data set where --data is given, otherwise around the scene)")
      ->transform(amount_in(1, std::int64_t{1} << 40));
  command
      ->add_option("--spz-version", settings->spz_version,
                   "version of a .spz: 3, read everywhere, or 4, smaller")
      ->check(whole_in(3, 4))
      ->capture_default_str();
  command->add_flag("--force", settings->force,
                    "replace OUT if it exists, instead of keeping it as OUT.~1~");
  add_crop_options(*command, settings->crop);
  add_map_options(*command, settings->map);
  add_compact_options(*command, *settings);
  add_data_options(*command, settings->data);
  command->callback([=, &action] {
    check_use(*settings, *command);
    action = [=] { return convert(*settings); };
  });
}

}  // namespace fluxgs::cli
