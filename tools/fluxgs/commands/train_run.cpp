#include "tools/fluxgs/commands/train_run.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include "fluxgs/io/scene.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/options/ineffective_options.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/data/scale_check.h"
#include "trainer/train/carving.h"
#include "trainer/train/checkpoint.h"
#include "trainer/train/memory_budget.h"

namespace fluxgs::cli {
namespace {

bool is_compact(const std::string& out) {
  const auto format = scene_format_for(out);
  return format && (*format)->name == "glb";
}

std::size_t max_initial(const Dataset& data, const TrainOptions& options) {
  std::size_t most = std::numeric_limits<std::size_t>::max();
  for (const std::uint64_t limit :
       {options.max_splats, options.target_splats, options.initial_splats})
    if (limit > 0) most = std::min<std::size_t>(most, limit);
  return std::min(most, splats_in_memory(data, options, kDefaultPairs));
}

/// Every n-th point keeps the cloud's coverage.
void thin_out(PointCloud& points, std::size_t most) {
  const std::size_t count = points.positions.size();
  if (count <= most) return;
  const double step = static_cast<double>(count) / static_cast<double>(most);
  for (std::size_t i = 0; i < most; ++i) {
    const auto from = static_cast<std::size_t>(static_cast<double>(i) * step);
    points.positions[i] = points.positions[from];
    points.colors[i] = points.colors[from];
  }
  points.positions.resize(most);
  points.colors.resize(most);
}

/// Refuses options with other values than those of the checkpoint, --iterations apart.
Expected<void> check_unchanged(const TrainSettings& settings, const Checkpoint& checkpoint) {
  MethodOptions changed = changed_options(settings.method, checkpoint.options);
  std::erase_if(changed, [](const auto& option) { return option.first == "iterations"; });
  const auto note = [&](const char* name, bool same, const std::string& value) {
    if (settings.given.contains(name) && !same) changed.emplace_back(name, value);
  };
  const glm::dvec3& background = checkpoint.options.render.background;
  note("preset", settings.preset == checkpoint.preset, checkpoint.preset);
  note("downscale", settings.data.downscale == checkpoint.downscale,
       fmt::format("{}", checkpoint.downscale));
  note("background", settings.data.background_color() == background,
       fmt::format("{:g},{:g},{:g}", background.x, background.y, background.z));
  if (changed.empty()) return {};
  return fail("", "--" + changed.front().first,
              fmt::format("cannot be changed with --resume; it is {} in {}", changed.front().second,
                          settings.resume));
}

/// Refuses other images than those of the checkpoint.
Expected<void> check_images(const TrainSettings& settings, const Dataset& data,
                            const Checkpoint& checkpoint) {
  if (data.train.size() != checkpoint.train_views)
    return fail(settings.data.folder, "",
                fmt::format("{} training images, expected the {} that {} was made with",
                            data.train.size(), checkpoint.train_views, settings.resume));
  if (hash_views(data.train) != checkpoint.views_hash)
    return fail(settings.data.folder, "",
                fmt::format("the images, their poses or which of them are for testing have changed "
                            "since {} was made; without --resume a new training begins",
                            settings.resume));
  return {};
}

/// Lets a training go on beyond its end: what its length decided stays as it was.
Expected<void> extend(TrainOptions& options, const MethodOptions& given) {
  TrainOptions asked = options;
  apply(given, asked);  // of all options, --iterations alone is left
  if (asked.iterations == options.iterations) return {};
  if (asked.iterations < options.iterations)
    return fail("", "--iterations",
                fmt::format("{} are fewer than the {} of the checkpoint's training",
                            asked.iterations, options.iterations));
  options = plan_schedule(std::move(options)).options;
  options.iterations = asked.iterations;
  return options.validate();
}

/// The checkpoint in settings.resume, with more iterations if these are asked for.
Expected<Checkpoint> read_own_checkpoint(const TrainSettings& settings) {
  auto checkpoint = read_checkpoint(settings.resume);
  if (!checkpoint) return checkpoint;
  if (auto ok = check_unchanged(settings, *checkpoint); !ok) return std::unexpected(ok.error());
  if (auto ok = extend(checkpoint->options, settings.method); !ok)
    return std::unexpected(ok.error());
  return checkpoint;
}

}  // namespace

// One that begins with a dash would be an option
std::string typed(const std::string& path) {
  return shell_quoted(path.starts_with('-') ? "./" + path : path);
}

Expected<TrainOptions> options_from(const TrainSettings& settings) {
  auto options = preset(settings.preset);
  if (!options) return options;
  options->compact_output = settings.out.empty() || is_compact(settings.out);
  apply(settings.method, *options);
  options->render.background = settings.data.background_color();
  if (auto valid = options->validate(); !valid) return std::unexpected(valid.error());
  if (options->max_splats > 0 && options->target_splats > options->max_splats)
    return fail("", "--target-splats",
                fmt::format("{} are more than --max-splats {}", options->target_splats,
                            options->max_splats));
  return options;
}

Expected<Run> new_run(TrainSettings& settings, const Threads& threads) {
  const auto options = options_from(settings);
  if (!options) return std::unexpected(options.error());
  settings.data.masks = options->get<MaskOptions>().masks;
  for (const std::string& line : ineffective_options(settings.given, *options))
    spdlog::warn("warning: {}", line);
  auto data = load(settings.data);
  if (!data) return std::unexpected(data.error());
  for (const std::string& line : scale_warnings(*data))
    spdlog::warn("warning: {}: {}", settings.data.folder, line);
  if (auto room = check_memory(*data, *options); !room) return std::unexpected(room.error());
  cv::setNumThreads(threads.count());  // it looks for features
  auto points = initial_points(*data, options->seed, threads, show_progress("pairs"));
  if (!points) return std::unexpected(points.error());
  thin_out(*points, max_initial(*data, *options));
  spdlog::info("{} initial splats ({})", points->positions.size(), points->source);
  TrainState state = initial_state(*data, *points, *options, threads);
  const std::uint64_t views_hash = hash_views(data->train);
  return Run{*options, std::move(*data), std::move(state), views_hash};
}

Expected<TrainOptions> resumed_options(const TrainSettings& settings) {
  auto checkpoint = read_own_checkpoint(settings);
  if (!checkpoint) return std::unexpected(checkpoint.error());
  return std::move(checkpoint->options);
}

Expected<Run> resume_run(TrainSettings& settings) {
  auto checkpoint = read_own_checkpoint(settings);
  if (!checkpoint) return std::unexpected(checkpoint.error());
  settings.preset = checkpoint->preset;
  settings.data.downscale = checkpoint->downscale;
  settings.data.masks = checkpoint->options.get<MaskOptions>().masks;
  const glm::dvec3 background = checkpoint->options.render.background;
  settings.data.background = {background.x, background.y, background.z};
  auto data = load(settings.data);
  if (!data) return std::unexpected(data.error());
  if (auto ok = check_images(settings, *data, *checkpoint); !ok) return std::unexpected(ok.error());
  if (checkpoint->state.iteration == checkpoint->options.iterations)
    spdlog::info("the training is finished; with more --iterations it would go on");
  spdlog::info("resuming at iteration {} with {} splats", checkpoint->state.iteration,
               checkpoint->state.parameters.size());
  return Run{checkpoint->options, std::move(*data), std::move(checkpoint->state),
             checkpoint->views_hash, history_of(checkpoint->history)};
}

std::string checkpoint_of(const TrainSettings& settings) { return settings.out + ".ckpt"; }

Expected<void> save_checkpoint(const std::string& path, const TrainSettings& settings,
                               const Run& run, const TrainHistory& history,
                               const Trainer& trainer) {
  return write_checkpoint(path, {run.options, settings.preset, settings.data.downscale,
                                 run.data.train.size(), run.views_hash, trainer.saved_state(),
                                 text_of(history), initial_view_of(run.data.train)});
}

std::string how_to_resume(const TrainSettings& settings, int iteration) {
  return fmt::format("Checkpoint of iteration {} saved. Resume with: {}", iteration,
                     resume_command(settings, checkpoint_of(settings)));
}

std::string resume_command(const TrainSettings& settings, const std::string& checkpoint) {
  std::string line = fmt::format("fluxgs train {} -o {} --resume {}", typed(settings.data.folder),
                                 typed(settings.out), typed(checkpoint));
  // What a checkpoint does not hold
  if (!settings.float_output.empty()) line += " --float-output " + typed(settings.float_output);
  if (settings.report == "-")
    line += " --json -";
  else if (!settings.report.empty())
    line += " --json " + typed(settings.report);
  if (!settings.data.holdout.empty()) line += " --holdout " + typed(settings.data.holdout);
  if (settings.data.threads > 0) line += fmt::format(" --threads {}", settings.data.threads);
  if (settings.checkpoint_every_text != TrainSettings().checkpoint_every_text)
    line += fmt::format(" --checkpoint-every {}", settings.checkpoint_every_text);
  return line;
}

}  // namespace fluxgs::cli
