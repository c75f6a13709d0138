// How long the stages of a training iteration take, beside what they work on.
#include <algorithm>
#include <map>
#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "trainer/core/clock.h"
#include "trainer/core/median.h"
#include "trainer/data/initial_points.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/opacity_reset.h"
#include "trainer/train/checkpoint.h"
#include "trainer/train/sh_curriculum.h"
#include "trainer/train/trainer.h"

namespace fluxgs {
namespace {

struct Settings {
  std::string data, checkpoint;
  int downscale = 2, warmup = 20, iterations = 200, threads = 0;
  bool json = false;
};

/// Milliseconds of each timed iteration, by stage.
using StageTimes = std::map<std::string, std::vector<double>>;

void add_times(const Profiler::Entries& entries, StageTimes& all) {
  for (const auto& [name, seconds] : entries) all[name].push_back(1e3 * seconds);
}

nlohmann::json medians(const StageTimes& times) {
  nlohmann::json result = nlohmann::json::object();
  for (const auto& [name, ms] : times) result[name] = *median(ms);
  return result;
}

/// Contributing splat–pixel pairs per pixel, over the training views, counted by a pass of its own.
double pairs_per_pixel(const Dataset& data, const TrainState& state, const TrainOptions& options,
                       const Threads& threads) {
  Profiler profiler;
  const auto rasterizer =
      make_cpu_rasterizer(threads, profiler, {.isa = best_isa(), .count_pixel_pairs = true});
  double pairs = 0, pixels = 0;
  for (const View& view : data.train) {
    rasterizer->forward(state.parameters, view.camera, options.render);
    pairs += static_cast<double>(rasterizer->counts().pixel_pairs);
    pixels += static_cast<double>(view.camera.width) * view.camera.height;
  }
  return pairs / pixels;
}

/// State of a checkpoint, or of the start of a run.
Expected<TrainState> starting_state(const Settings& settings, const Dataset& data,
                                    const TrainOptions& options, const Threads& threads) {
  if (!settings.checkpoint.empty()) {
    auto checkpoint = read_checkpoint(settings.checkpoint);
    if (!checkpoint) return std::unexpected(checkpoint.error());
    return std::move(checkpoint->state);
  }
  const auto points = initial_points(data, 1, threads);
  if (!points) return std::unexpected(points.error());
  return initial_state(data, *points, options, threads);
}

Expected<void> run(const Settings& settings) {
  LoadOptions load;
  load.downscale = settings.downscale;
  const auto data = load_dataset(settings.data, load);
  if (!data) return std::unexpected(data.error());

  const Threads threads(settings.threads);
  TrainOptions options = default_options();
  options.get<DensificationOptions>().from = 1 << 30;  // the same splats throughout
  options.get<OpacityResetOptions>().interval = 0;
  options.get<ShCurriculumOptions>().interval = 1;  // every coefficient in use, as most of the time
  Profiler profiler;
  auto state = starting_state(settings, *data, options, threads);
  if (!state) return std::unexpected(state.error());
  const double density = pairs_per_pixel(*data, *state, options, threads);
  Trainer trainer(*data, options, std::move(*state), threads, profiler);
  for (int i = 0; i < settings.warmup; ++i) trainer.step();

  std::vector<double> wall_ms, cpu_ms;
  StageTimes stage_ms, stage_cpu_ms;
  for (int i = 0; i < settings.iterations; ++i) {
    profiler.clear();
    const double wall = wall_seconds(), cpu = cpu_seconds();
    trainer.step();
    wall_ms.push_back(1e3 * (wall_seconds() - wall));
    cpu_ms.push_back(1e3 * (cpu_seconds() - cpu));
    add_times(profiler.entries(), stage_ms);
    add_times(profiler.cpu_entries(), stage_cpu_ms);
  }

  const Camera& camera = data->train.front().camera;
  const double pairs = density * camera.width * camera.height;
  if (settings.json) {
    fmt::print("{}\n", nlohmann::json{{"width", camera.width},
                                      {"height", camera.height},
                                      {"splats", trainer.state.parameters.size()},
                                      {"pairs_per_pixel", density},
                                      {"instruction_set", name_of(best_isa())},
                                      {"threads", threads.count()},
                                      {"wall_ms", *median(wall_ms)},
                                      {"cpu_ms", *median(cpu_ms)},
                                      {"stages", medians(stage_ms)},
                                      {"stages_cpu", medians(stage_cpu_ms)}}
                           .dump());
    return {};
  }
  fmt::print("{}x{}, {} splats, {:.1f} contributing pairs a pixel, {}, {} threads\n", camera.width,
             camera.height, trainer.state.parameters.size(), density, name_of(best_isa()),
             threads.count());
  fmt::print("{:<20} {:>8}\n", "stage", "median ms (wall)");
  for (const auto& [name, ms] : stage_ms) fmt::print("{:<20} {:>8.3f}\n", name, *median(ms));
  fmt::print(
      "iteration: median {:.2f} ms wall, {:.2f} ms CPU ({:.2f} ns CPU per contributing pair); "
      "cores used: {:.0f}%\n",
      *median(wall_ms), *median(cpu_ms), 1e6 * *median(cpu_ms) / pairs,
      100 * *median(cpu_ms) / (*median(wall_ms) * threads.count()));
  return {};
}

}  // namespace
}  // namespace fluxgs

int main(int argc, char** argv) {
  fluxgs::Settings settings;
  CLI::App app(
      "Times the stages of a training iteration on a data set's initial splats or a\n"
      "checkpoint's, with all spherical harmonics in use.\n"
      "Example: train_benchmark captures/garden --downscale 4");
  app.add_option("data", settings.data, "data set, as for fluxgs train")->required();
  app.add_option("--checkpoint", settings.checkpoint, "start from a file that fluxgs train left");
  app.add_option("--downscale", settings.downscale, "reduce the images by this factor")
      ->capture_default_str();
  app.add_option("--warmup", settings.warmup, "iterations before the clock starts")
      ->capture_default_str();
  app.add_option("--iterations", settings.iterations, "iterations timed")->capture_default_str();
  app.add_option("--threads", settings.threads, "0: all cores")->capture_default_str();
  app.add_flag("--json", settings.json, "the last line is one object; stages_cpu: processor time");
  CLI11_PARSE(app, argc, argv);
  spdlog::set_pattern("%v");
  if (const auto done = fluxgs::run(settings); !done) {
    fmt::print(stderr, "train_benchmark: error: {}\n", done.error().message());
    return 1;
  }
  return 0;
}
