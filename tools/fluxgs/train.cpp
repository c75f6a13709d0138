// fluxgs train: photos in, a scene file out.
#include <algorithm>
#include <filesystem>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <opencv2/core/version.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/printable.h"
#include "tools/fluxgs/command.h"
#include "tools/fluxgs/console.h"
#include "tools/fluxgs/data_options.h"
#include "tools/fluxgs/interrupt.h"
#include "tools/fluxgs/method_options.h"
#include "tools/fluxgs/peak_memory.h"
#include "tools/fluxgs/progress.h"
#include "trainer/base/clock.h"
#include "trainer/train/checkpoint.h"
#include "trainer/train/evaluate.h"
#include "trainer/train/memory_budget.h"
#include "trainer/train/store_scene.h"
#include "trainer/train/trainer.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

struct TrainSettings {
  std::string out, exact, preset = preset_names().front(), backend = "auto", resume, report;
  DataOptions data;
  int checkpoint_every = 0;
  MethodOptions method;
};

/// Means over equal stretches of the run, for plots.
class Curves {
 public:
  explicit Curves(int iterations) : stretch_(std::max(1, iterations / 200)) {}

  void add(int iteration, const StepReport& step, std::size_t splats) {
    loss_ += step.loss;
    l1_ += step.sums.l1;
    if (++count_ < stretch_) return;
    iteration_.push_back(iteration);
    losses_.push_back(loss_ / count_);
    l1s_.push_back(l1_ / count_);
    splats_.push_back(splats);
    const double now = wall_seconds();
    rates_.push_back(count_ / std::max(now - start_, 1e-9));
    start_ = now;
    loss_ = l1_ = count_ = 0;
  }

  /// Twenty times in all, halfway between the even marks, at many of which opacities are reset.
  bool psnr_is_due(int iteration) const { return iteration % (10 * stretch_) == 5 * stretch_; }
  /// Measures the test views; the time that takes is not part of the training's.
  void measure_psnr(int iteration, const Trainer& trainer, const std::vector<Photo>& photos) {
    const double start = wall_seconds(), cpu_start = cpu_seconds();
    psnr_.push_back({iteration, trainer.mean_psnr(photos)});
    measuring_ += wall_seconds() - start;
    measuring_cpu_ += cpu_seconds() - cpu_start;
  }
  double measuring_seconds() const { return measuring_; }
  double measuring_cpu_seconds() const { return measuring_cpu_; }
  void add_switch(int iteration, const SwitchReport& report) {
    switch_ = {{"iteration", iteration},
               {"train_psnr", {report.train_psnr_before, report.train_psnr_after}},
               {"test_psnr", {report.test_psnr_before, report.test_psnr_after}},
               {"bytes", {report.bytes_before, report.bytes_after}},
               {"mse_if_truncated", report.reduction.dropped},
               {"mse_if_fitted", report.reduction.unexplained},
               {"splats_of_degree", report.reduction.degrees}};
    psnr_.push_back({iteration, report.test_psnr_before});
    psnr_.push_back({iteration, report.test_psnr_after});
  }

  void add_late_prune(int iteration, const LatePruneReport& report) {
    late_prunes_.push_back({{"iteration", iteration},
                            {"splats", {report.splats_before, report.splats_after}},
                            {"train_psnr", {report.train_psnr_before, report.train_psnr_after}}});
  }
  void add_rounding(int iteration, const RoundingReport& report) {
    rounding_ = {{"iteration", iteration},
                 {"bytes", report.bytes},
                 {"train_psnr", {report.train_psnr_before, report.train_psnr_after}}};
  }

  json to_json() const {
    return {{"switch", switch_}, {"rounding", rounding_},   {"late_prunes", late_prunes_},
            {"psnr", psnr_},     {"iteration", iteration_}, {"loss", losses_},
            {"l1", l1s_},        {"splats", splats_},       {"iterations_per_second", rates_}};
  }
  double first_rate() const { return rates_.empty() ? 0 : rates_.front(); }
  double last_rate() const { return rates_.empty() ? 0 : rates_.back(); }

 private:
  int stretch_, count_ = 0;
  double loss_ = 0, l1_ = 0, start_ = wall_seconds(), measuring_ = 0, measuring_cpu_ = 0;
  std::vector<int> iteration_;
  std::vector<double> losses_, l1s_, rates_;
  std::vector<std::size_t> splats_;
  std::vector<std::pair<int, double>> psnr_;
  json switch_, rounding_, late_prunes_ = json::array();
};

Expected<TrainOptions> options_from(const TrainSettings& settings) {
  auto options = preset(settings.preset);
  if (!options) return options;
  apply(settings.method, *options);
  options->render.background = settings.data.background_color();
  if (auto valid = validate(*options); !valid) return std::unexpected(valid.error());
  return options;
}

/// Fails now rather than after hours of work if the result could not be written.
Expected<void> check_writable(const std::string& path) {
  const auto probe = AtomicFile::create(path);
  if (!probe) return std::unexpected(probe.error());
  return {};
}

/// Of --exact, which may be missing.
Expected<void> check_exact(const TrainSettings& settings) {
  if (settings.exact.empty()) return {};
  if (const auto format = scene_format_for(settings.exact); !format)
    return std::unexpected(format.error());
  return check_writable(settings.exact);
}

/// Whether a file would be inside a folder, whose own .json files must not be overwritten.
bool lies_in(const std::string& file, const std::string& folder) {
  std::error_code ignored;
  const auto inside = std::filesystem::weakly_canonical(file, ignored).parent_path();
  return inside == std::filesystem::weakly_canonical(std::filesystem::path(folder) / "x", ignored)
                       .parent_path();
}

/// A run to start or to go on with.
struct Run {
  TrainOptions options;
  Dataset data;
  TrainState state;
  std::uint64_t photos_hash;
};

Expected<Run> resume_run(TrainSettings& settings) {
  auto checkpoint = read_checkpoint(settings.resume);
  if (!checkpoint) return std::unexpected(checkpoint.error());
  settings.preset = checkpoint->preset;
  settings.data.downscale = checkpoint->downscale;
  const glm::dvec3 background = checkpoint->options.render.background;
  settings.data.background = {background.x, background.y, background.z};
  auto data = load(settings.data);
  if (!data) return std::unexpected(data.error());
  if (data->train.size() != checkpoint->train_photos ||
      hash_photos(data->train) != checkpoint->photos_hash)
    return fail(settings.data.folder, "",
                fmt::format("{} training photos, but not the {} that {} was made with",
                            data->train.size(), checkpoint->train_photos, settings.resume));
  spdlog::info("resuming at iteration {} with {} splats", checkpoint->state.iteration,
               checkpoint->state.parameters.size());
  return Run{checkpoint->options, std::move(*data), std::move(checkpoint->state),
             checkpoint->photos_hash};
}

std::size_t most_initial(const Dataset& data, const TrainOptions& options) {
  std::size_t most = std::numeric_limits<std::size_t>::max();
  for (const std::uint64_t limit :
       {options.max_splats, options.target_splats, options.initial_splats})
    if (limit > 0) most = std::min<std::size_t>(most, limit);
  return std::min(most, splats_in_memory(data, options, kUsualPairs));
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

Expected<Run> new_run(const TrainSettings& settings, const Threads& threads) {
  const auto options = options_from(settings);
  if (!options) return std::unexpected(options.error());
  auto data = load(settings.data);
  if (!data) return std::unexpected(data.error());
  if (auto room = check_memory(*data, *options); !room) return std::unexpected(room.error());
  auto points = initial_points(*data, options->seed, show_progress("pairs"));
  if (!points) return std::unexpected(points.error());
  thin_out(*points, most_initial(*data, *options));
  spdlog::info("{} initial splats ({})", points->positions.size(), points->source);
  TrainState state = initial_state(*data, *points, *options, threads);
  const std::uint64_t photos_hash = hash_photos(data->train);
  return Run{*options, std::move(*data), std::move(state), photos_hash};
}

Expected<void> save_checkpoint(const TrainSettings& settings, const Run& run,
                               const Trainer& trainer) {
  return write_checkpoint(settings.out + ".ckpt",
                          {run.options, settings.preset, settings.data.downscale,
                           run.data.train.size(), run.photos_hash, trainer.state()});
}

void report_switch(int iteration, const SwitchReport& report, Curves& curves) {
  curves.add_switch(iteration, report);
  spdlog::info(
      "harmonics reduced: {:.2f} to {:.2f} dB on training views, {:.2f} to {:.2f} on test; a file "
      "of {} bytes to {}",
      report.train_psnr_before, report.train_psnr_after, report.test_psnr_before,
      report.test_psnr_after, report.bytes_before, report.bytes_after);
  const auto& degrees = report.reduction.degrees;
  if (degrees[0] + degrees[1] + degrees[2] > 0)
    spdlog::info("splats of degree 0 to 3: {}", fmt::join(degrees, ", "));
}

void report_late_prune(int iteration, const LatePruneReport& report, Curves& curves) {
  curves.add_late_prune(iteration, report);
  spdlog::info("late pruning: {} to {} splats, {:.2f} to {:.2f} dB on training views",
               report.splats_before, report.splats_after, report.train_psnr_before,
               report.train_psnr_after);
}

void report_rounding(int iteration, const RoundingReport& report, Curves& curves) {
  if (report.error)
    return spdlog::warn("warning: nothing is rounded from step {} on: {}", iteration,
                        report.error->message());
  curves.add_rounding(iteration, report);
  spdlog::info("rounded as in a file of {} bytes: {:.2f} to {:.2f} dB on training views",
               report.bytes, report.train_psnr_before, report.train_psnr_after);
}

/// Trains to the end; an interruption saves a checkpoint and is an error that says how to go on.
Expected<void> train_to_end(const TrainSettings& settings, const Run& run, Trainer& trainer,
                            Curves& curves) {
  const InterruptCounter interrupts(SecondInterrupt::ends_the_program);
  Progress progress("it", run.options.iterations, trainer.state().iteration);
  double smooth_loss = 0;
  while (!trainer.done()) {
    const StepReport step = trainer.step();
    const int i = trainer.state().iteration;
    const std::size_t splats = trainer.state().parameters.size();
    curves.add(i, step, splats);
    if (step.switched) report_switch(i, *step.switched, curves);
    if (step.pruned_late) report_late_prune(i, *step.pruned_late, curves);
    if (step.rounded) report_rounding(i, *step.rounded, curves);
    if (curves.psnr_is_due(i)) curves.measure_psnr(i, trainer, run.data.test);
    smooth_loss = smooth_loss > 0 ? 0.98 * smooth_loss + 0.02 * step.loss : step.loss;
    if (progress.due())
      progress.update(i, fmt::format("{} splats  loss {:.4f}", splats, smooth_loss));
    if (splats == 0)
      return fail(settings.data.folder, fmt::format("iteration {}", i),
                  "no splat is left; the poses or the photos do not fit together");
    const bool periodic = settings.checkpoint_every > 0 && i % settings.checkpoint_every == 0;
    const bool interrupted = interrupts.count() > 0;
    if (!periodic && !interrupted) continue;
    if (auto saved = save_checkpoint(settings, run, trainer); !saved) return saved;
    if (interrupted)
      return fail("", fmt::format("interrupted at iteration {}", i),
                  fmt::format("saved; go on with: fluxgs train {} -o {} --resume {}",
                              shell_quoted(settings.data.folder), shell_quoted(settings.out),
                              shell_quoted(settings.out + ".ckpt")));
  }
  progress.finish(trainer.state().iteration);
  return {};
}

json report_json(const TrainSettings& settings, const Run& run, const Trainer& trainer,
                 const Curves& curves, const StageTimes& times, double seconds, double cpu,
                 int steps) {
  json stages = json::object();
  for (std::size_t s = 0; s < kStageNames.size(); ++s)
    stages[std::string(kStageNames[s])] = 1e3 * times.seconds[s] / std::max(steps, 1);
  return {{"data", settings.data.folder},
          {"preset", settings.preset},
          {"options", options_json(resolved(run.options))},
          {"downscale", settings.data.downscale},
          {"backend", "cpu"},
          {"instruction_set", name_of(best_isa())},
          {"iterations", trainer.state().iteration},
          {"seconds", seconds},
          {"cpu_seconds", cpu},
          {"cpu_ms_per_iteration", 1e3 * cpu / std::max(steps, 1)},
          {"iterations_per_second", {{"start", curves.first_rate()}, {"end", curves.last_rate()}}},
          {"splats", trainer.state().parameters.size()},
          {"peak_memory_bytes", peak_memory()},
          {"rejected_gradients", trainer.rejected_gradients()},
          {"stages", stages},
          {"curves", curves.to_json()},
          {"versions",
           {{"fluxgs", FLUXGS_VERSION}, {"opencv", CV_VERSION}, {"compiler", __VERSION__}}}};
}

Expected<StoredScene> store(const Run& run, const Trainer& trainer, const Threads& threads) {
  Progress progress("trials", CompactSearch::kUsualTrials, 0);
  int trials = 0;
  auto stored = store_scene(trainer, run.data.train, threads, [&](const CompactTrial& t) {
    progress.update(++trials, fmt::format("{} bytes  {}", t.file.size(), decibels(t.psnr())));
  });
  progress.clear();
  if (stored && stored->with_networks)
    spdlog::info("networks: {} bytes with them, {} without, at the same error: {}",
                 *stored->with_networks, *stored->without_networks,
                 *stored->with_networks < *stored->without_networks ? "kept" : "left out");
  return stored;
}

/// Writes a compact .glb or another format, and returns the scene that the file holds.
Expected<SplatCloud> write_out(const TrainSettings& settings, const Run& run,
                               const Trainer& trainer, const Threads& threads, json& report) {
  SplatCloud cloud = trainer.cloud();
  if (!settings.exact.empty())
    if (auto written = write_scene(settings.exact, cloud); !written)
      return std::unexpected(written.error());
  if ((*scene_format_for(settings.out))->name != "glb") {
    if (auto written = write_scene(settings.out, cloud); !written)
      return std::unexpected(written.error());
    return cloud;
  }
  auto stored = store(run, trainer, threads);
  if (!stored) return fail(settings.out, stored.error().field, stored.error().what);
  if (auto written = write_file_atomic(settings.out, stored->file); !written)
    return std::unexpected(written.error());
  report["bytes"] = stored->file.size();
  if (stored->with_networks)
    report["bytes_with_networks"] = *stored->with_networks,
    report["bytes_without_networks"] = *stored->without_networks;
  return std::move(stored->cloud);
}

/// The scene and, of its test views, the error.
Expected<void> write_results(const TrainSettings& settings, const Run& run, const Trainer& trainer,
                             const Threads& threads, json& report) {
  const auto cloud = write_out(settings, run, trainer, threads, report);
  if (!cloud) return std::unexpected(cloud.error());
  if (run.data.test.empty()) return {};
  const auto score_of = [&](const SplatCloud& scene) {
    return evaluate(run.data.test, cpu_view_renderer(scene, run.options.render, threads), threads,
                    show_progress("views"));
  };
  const auto score = score_of(*cloud);
  const bool stored = report.contains("bytes");
  const auto before = stored ? score_of(trainer.cloud()) : score;
  if (!score) return std::unexpected(score.error());
  if (!before) return std::unexpected(before.error());
  report["psnr"] = score->psnr;
  report["ssim"] = score->ssim;
  report["psnr_before_storing"] = before->psnr;
  report["ssim_before_storing"] = before->ssim;
  say(fmt::format("test views: PSNR {:.2f} dB, SSIM {:.4f}\n", score->psnr, score->ssim));
  return {};
}

Expected<void> train(TrainSettings settings) {
  if (settings.backend == "cuda")
    return fail("", "--backend cuda", "this build has no CUDA backend; use --backend cpu");
  const auto format = scene_format_for(settings.out);
  if (!format) return std::unexpected(format.error());
  if (auto ok = check_writable(settings.out); !ok) return ok;
  if (auto ok = check_exact(settings); !ok) return ok;
  if (!settings.report.empty() && settings.report != "-") {
    if (std::filesystem::path(settings.report).extension() != ".json" ||
        lies_in(settings.report, settings.data.folder))
      return fail(settings.report, "--json",
                  "expected a name that ends in .json, outside of the data set");
    if (auto ok = check_writable(settings.report); !ok) return ok;
  }

  const Threads threads(settings.data.threads);
  auto run = settings.resume.empty() ? new_run(settings, threads) : resume_run(settings);
  if (!run) return std::unexpected(run.error());
  warn_of_lost_degrees(settings.out, **format, target_degree(run->options));

  StageTimes times;
  Trainer trainer(run->data, run->options, std::move(run->state), threads, times);
  Curves curves(run->options.iterations - trainer.state().iteration);
  const double start = wall_seconds(), cpu_start = cpu_seconds();
  const int first = trainer.state().iteration;
  if (auto done = train_to_end(settings, *run, trainer, curves); !done) return done;
  const double seconds = wall_seconds() - start - curves.measuring_seconds();
  const double cpu = cpu_seconds() - cpu_start - curves.measuring_cpu_seconds();

  json report = report_json(settings, *run, trainer, curves, times, seconds, cpu,
                            trainer.state().iteration - first);
  if (auto written = write_results(settings, *run, trainer, threads, report); !written)
    return written;
  say(fmt::format("{}: {} splats, {:.1f} s\n", one_line(settings.out, std::string::npos),
                  trainer.state().parameters.size(), seconds));
  if (settings.report == "-")
    print_json(report);
  else if (!settings.report.empty())
    return write_json(settings.report, report);
  return {};
}

/// A checkpoint brings every option but these.
bool stays_free_on_resume(const std::string& name) {
  const std::string_view free[] = {
      "data", "out", "exact", "resume", "threads", "backend", "json", "checkpoint-every", "help"};
  return std::ranges::find(free, name) != std::end(free);
}

}  // namespace

void add_train(CLI::App& app, Action& action) {
  auto settings = std::make_shared<TrainSettings>();
  CLI::App* command = app.add_subcommand("train", "Train a scene from posed photos");
  command->footer(
      "DATA is a COLMAP folder (sparse/0 and images/), a folder with transforms.json or\n"
      "transforms_train.json, or a folder of photos (then COLMAP is run, if installed).\n"
      "Ctrl-C saves OUT.ckpt, from which --resume goes on exactly as if nothing had happened.\n"
      "Example: fluxgs train captures/garden -o garden.glb --downscale 2 --iterations 7000");
  command->add_option("data", settings->data.folder, "the data set")->required();
  command->add_option("-o,--out", settings->out, "the scene to write: .glb or .ply")->required();
  command->add_option("--preset", settings->preset, "defaults of everything below")
      ->check(CLI::IsMember(preset_names()))
      ->capture_default_str();
  command->add_option("--exact", settings->exact,
                      "also write the scene as it was before it was made compact, such as a .ply");
  add_data_options(*command, settings->data);
  command->add_option("--backend", settings->backend, "auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command->add_option("--resume", settings->resume, "go on from a checkpoint, with its options");
  command
      ->add_option("--checkpoint-every", settings->checkpoint_every,
                   "steps between saves of OUT.ckpt (0: never)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--json", settings->report,
                      "write a report of the run here (-: standard output)");
  add_method_options(*command, settings->method);
  command->callback([settings, command, &action] {
    for (const CLI::Option* option : command->get_options())
      if (!settings->resume.empty() && option->count() > 0 &&
          !stays_free_on_resume(option->get_single_name()))
        throw CLI::ValidationError("--" + option->get_single_name(),
                                   "cannot be changed with --resume");
    action = [settings] { return train(*settings); };
  });
}

}  // namespace fluxgs::cli
