// fluxgs train: images in, a scene file out.
#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/sanitize.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/train_log.h"
#include "tools/fluxgs/commands/train_run.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/files.h"
#include "tools/fluxgs/terminal/interrupt.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/peak_memory.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/core/clock.h"
#include "trainer/train/checkpoint.h"
#include "trainer/train/evaluate.h"
#include "trainer/train/store_scene.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

/// Fails now rather than after hours of work if the result could not be written.
Expected<void> check_writable(const std::string& path) {
  const auto probe = AtomicFile::create(path);
  if (!probe) return std::unexpected(probe.error());
  return {};
}

/// Checks --float-output, which may be missing.
Expected<void> check_float_output(const TrainSettings& settings) {
  if (settings.float_output.empty()) return {};
  if (const auto format = scene_format_for(settings.float_output); !format)
    return std::unexpected(format.error());
  return check_writable(settings.float_output);
}

/// Everything that is to be written can be; a report in the data set would be taken for poses.
Expected<void> check_outputs(const TrainSettings& settings) {
  if (auto ok = check_writable(settings.out); !ok) return ok;
  if (auto ok = check_float_output(settings); !ok) return ok;
  if (settings.report.empty() || settings.report == "-") return {};
  if (std::filesystem::path(settings.report).extension() != ".json" ||
      lies_in(settings.report, settings.data.folder))
    return fail(settings.report, "--json",
                "expected a name that ends in .json, outside of the data set");
  return check_writable(settings.report);
}

/// Size of a file that was just written; null if somebody took it away.
json size_of(const std::string& path) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  return error ? json() : json(bytes);
}

/// Points that a training begins with are not overwritten by its result.
Expected<void> check_inputs_stay(const TrainSettings& settings, const Dataset& data) {
  for (const std::string& path : {settings.out, settings.float_output})
    if (same_file(path, data.points_file))
      return fail(path, "", "holds the points of the data set, expected another name to write to");
  return {};
}

/// A run at work: steps, then its scene, then its report.
class TrainCommand {
 public:
  TrainCommand(const TrainSettings& settings, Run run, const Threads& threads)
      : settings_(settings),
        run_(std::move(run)),
        threads_(threads),
        first_(run_.state.iteration),
        trainer_(run_.data, run_.options, std::move(run_.state), threads, profiler_),
        log_(run_.options.iterations) {}

  /// An interruption saves a checkpoint and is an error that says how to go on.
  Expected<void> to_end();

  /// The scene and its error. Nothing of the training is lost where that fails.
  Expected<void> write_results() {
    auto written = write_scenes();
    if (written) return {};
    const auto saved = save_checkpoint(settings_, run_, history(), trainer_);
    const Error& error = written.error();
    return fail(
        error.file, error.field,
        error.what + (saved ? ". " + how_to_resume(settings_)
                            : "; the training cannot be saved either: " + saved.error().message()));
  }

  Expected<void> write_report() {
    return give_report(settings_.report, report_, [] {});
  }

 private:
  Expected<void> after_step(const IterationReport& step, Progress& progress);
  TrainHistory history() const;
  void make_report();
  Expected<void> write_scenes();
  Expected<void> write_float_output();
  Expected<std::optional<SplatCloud>> write_out();
  Expected<StoredScene> store();
  void save_once();
  Expected<void> score(const std::optional<SplatCloud>& stored);

  /// A result; standard output is the report's where that goes there.
  void tell(const std::string& line) const {
    if (settings_.report == "-")
      say(line);
    else
      fmt::print("{}", line);
  }

  const InterruptCounter interrupts_{SecondInterrupt::ends_the_program};
  const TrainSettings& settings_;
  Run run_;
  const Threads& threads_;
  int first_;  ///< the steps that were done before
  Profiler profiler_;
  Trainer trainer_;
  TrainLog log_;
  const double start_ = wall_seconds(), cpu_start_ = cpu_seconds();
  double smooth_loss_ = 0;
  std::optional<TrainHistory> whole_;  ///< once all steps are done
  bool saved_ = false;
  json report_;
};

Expected<void> TrainCommand::to_end() {
  Progress progress("it", run_.options.iterations, first_);
  while (!trainer_.done())
    if (auto ok = after_step(trainer_.step(), progress); !ok) return ok;
  progress.finish(trainer_.state.iteration);
  make_report();
  return {};
}

Expected<void> TrainCommand::after_step(const IterationReport& step, Progress& progress) {
  const int i = trainer_.state.iteration;
  const std::size_t splats = trainer_.state.parameters.size();
  log_.add(i, step, splats);
  if (log_.psnr_is_due(i)) log_.measure_psnr(i, trainer_, run_.data.test);
  smooth_loss_ = smooth_loss_ > 0 ? 0.98 * smooth_loss_ + 0.02 * step.loss : step.loss;
  if (progress.due())
    progress.update(i, fmt::format("{} splats  loss {:.4f}", splats, smooth_loss_));
  if (splats == 0)
    return fail(settings_.data.folder, fmt::format("iteration {}", i),
                "all splats were pruned: the poses probably do not match the images");
  const bool interrupted = interrupts_.count() > 0;
  const bool periodic = settings_.checkpoint_every > 0 && i % settings_.checkpoint_every == 0;
  if (!periodic && !interrupted) return {};
  const auto saved = save_checkpoint(settings_, run_, history(), trainer_);
  if (interrupted)
    return saved ? fail("", fmt::format("interrupted at iteration {}", i), how_to_resume(settings_))
                 : saved;
  if (!saved)
    spdlog::warn("warning: no checkpoint at iteration {}: {}", i, saved.error().message());
  return {};
}

/// History of the iterations up to now, without the time of measuring them.
TrainHistory TrainCommand::history() const {
  if (whole_) return *whole_;
  return joined(run_.history, {wall_seconds() - start_ - log_.measuring_seconds(),
                               cpu_seconds() - cpu_start_ - log_.measuring_cpu_seconds(),
                               trainer_.rejected_gradients(),
                               {profiler_.entries().begin(), profiler_.entries().end()},
                               log_.to_json()});
}

void TrainCommand::make_report() {
  whole_ = history();
  const TrainHistory& all = *whole_;
  const int steps = std::max(trainer_.state.iteration, 1);
  json stages = json::object();
  for (const auto& [name, seconds] : all.stages) stages[name] = 1e3 * seconds / steps;
  json rates = all.curves.at("iterations_per_second");
  if (rates.empty()) rates = {0.0};
  report_ = {
      {"data", settings_.data.folder},
      {"out", settings_.out},
      {"float_output", settings_.float_output.empty() ? json() : json(settings_.float_output)},
      {"checkpoint_every", settings_.checkpoint_every},
      {"preset", settings_.preset},
      {"options", options_json(trainer_.options)},
      {"downscale", settings_.data.downscale},
      {"background", settings_.data.background},
      {"backend", "cpu"},
      {"threads", threads_.count()},
      {"instruction_set", name_of(best_isa())},
      {"iterations", trainer_.state.iteration},
      {"resumed_at", first_},
      {"seconds", all.seconds},
      {"cpu_seconds", all.cpu_seconds},
      {"cpu_ms_per_iteration", 1e3 * all.cpu_seconds / steps},
      {"iterations_per_second", {{"start", rates.front()}, {"end", rates.back()}}},
      {"splats", trainer_.state.parameters.size()},
      {"rejected_gradients", all.rejected_gradients},
      {"stages", stages},
      {"curves", all.curves},
      {"versions",
       {{"fluxgs", FLUXGS_VERSION}, {"opencv", CV_VERSION}, {"compiler", __VERSION__}}}};
}

/// The first Ctrl-C while the scene is stored: that goes on, but a second one may end it.
void TrainCommand::save_once() {
  if (saved_ || interrupts_.count() == 0) return;
  saved_ = true;
  if (const auto saved = save_checkpoint(settings_, run_, history(), trainer_); saved)
    spdlog::info("the scene is still being stored. {}", how_to_resume(settings_));
  else
    spdlog::warn("warning: {}", saved.error().message());
}

Expected<StoredScene> TrainCommand::store() {
  Progress progress("trials", CompactSearch::kDefaultTrials, 0);
  int trials = 0;
  auto stored = store_scene(trainer_, run_.data.train, threads_, [&](const CompactTrial& t) {
    save_once();
    progress.update(++trials, fmt::format("{} bytes  {}", t.file.size(), decibels(t.psnr())));
  });
  progress.clear();
  if (!stored) return fail(settings_.out, stored.error().field, stored.error().what);
  if (stored->networks_error) {
    report_["networks_error"] = stored->networks_error->message();
    spdlog::warn("warning: stored without networks: {}", stored->networks_error->message());
  }
  if (!stored->with_networks) return stored;
  report_["bytes_with_networks"] = *stored->with_networks;
  report_["bytes_without_networks"] = *stored->without_networks;
  spdlog::info("networks: {} bytes with them, {} without, at the same error: {}",
               *stored->with_networks, *stored->without_networks,
               *stored->with_networks < *stored->without_networks ? "kept" : "left out");
  return stored;
}

/// --float-output, if there is one.
Expected<void> TrainCommand::write_float_output() {
  if (settings_.float_output.empty()) return {};
  if (auto written = write_scene(settings_.float_output, trainer_.cloud()); !written)
    return written;
  report_["float_bytes"] = size_of(settings_.float_output);
  return {};
}

/// Writes a compact .glb or another format. Returns the scene that the file holds where it is not
/// the trainer's to the bit and there are images to compare it with.
Expected<std::optional<SplatCloud>> TrainCommand::write_out() {
  const std::string_view format = (*scene_format_for(settings_.out))->name;
  if (format == "glb") {
    auto stored = store();
    if (!stored) return std::unexpected(stored.error());
    const auto bytes = write_glb(settings_.out, stored->file, initial_view_of(run_.data.train));
    if (!bytes) return std::unexpected(bytes.error());
    report_["bytes"] = *bytes;
    return std::move(stored->cloud);
  }
  if (auto written = write_scene(settings_.out, trainer_.cloud()); !written)
    return std::unexpected(written.error());
  report_["bytes"] = size_of(settings_.out);
  if (format == "ply") return std::nullopt;
  auto stored = read_scene(settings_.out);
  if (!stored) return std::unexpected(stored.error());
  return std::move(stored->cloud);
}

/// Scores the trainer's scene and, if it is another, the one in the file: against the test views,
/// or against the training views where all images are trained on.
Expected<void> TrainCommand::score(const std::optional<SplatCloud>& stored) {
  const bool held_out = !run_.data.test.empty();
  const std::vector<View>& views = held_out ? run_.data.test : run_.data.train;
  const auto score_of = [&](const SplatCloud& scene) {
    return evaluate(views, cpu_view_renderer(scene, run_.options.render, threads_), threads_,
                    show_progress("views"));
  };
  const auto before = score_of(trainer_.cloud());
  const auto score = stored ? score_of(*stored) : before;
  if (!score) return std::unexpected(score.error());
  if (!before) return std::unexpected(before.error());
  report_["scored_views"] = held_out ? "test" : "train";
  report_["psnr"] = score->psnr;
  report_["ssim"] = score->ssim;
  report_["psnr_before_compression"] = before->psnr;
  report_["ssim_before_compression"] = before->ssim;
  tell(fmt::format("{}: PSNR {:.2f} dB, SSIM {:.4f}\n",
                   held_out ? "test views" : "training views, as there are none for testing",
                   score->psnr, score->ssim));
  return {};
}

Expected<void> TrainCommand::write_scenes() {
  if (auto written = write_float_output(); !written) return written;
  const auto stored = write_out();
  if (!stored) return std::unexpected(stored.error());
  if (auto scored = score(*stored); !scored) return scored;
  report_["peak_memory_bytes"] = peak_memory();
  tell(fmt::format("{}: {} splats, {:.1f} s\n", one_line(settings_.out, std::string::npos),
                   trainer_.state.parameters.size(), whole_->seconds));
  if (run_.options.render.background != glm::dvec3(0))
    spdlog::info("scene files have no background: eval, render and view need --background {}, too",
                 fmt::join(settings_.data.background, ","));
  return {};
}

/// --plan: the schedule of the options, without data. With --json the options themselves.
Expected<void> print_plan(const TrainSettings& settings) {
  const auto options = options_from(settings);
  if (!options) return std::unexpected(options.error());
  const Schedule schedule = plan_schedule(*options);
  return give_report(settings.report, {{"options", options_json(schedule.options)}},
                     [&] { fmt::print("{}", plan_table(schedule)); });
}

Expected<void> train(TrainSettings settings) {
  if (settings.plan) return print_plan(settings);
  if (settings.backend == "cuda")
    return fail("", "--backend cuda", "this build has no CUDA backend; use --backend cpu");
  const auto format = scene_format_for(settings.out);
  if (!format) return std::unexpected(format.error());
  if (auto ok = check_outputs(settings); !ok) return ok;

  const Threads threads(settings.data.threads);
  auto run = settings.resume.empty() ? new_run(settings, threads) : resume_run(settings);
  if (!run) return std::unexpected(run.error());
  if (auto ok = check_inputs_stay(settings, run->data); !ok) return ok;
  warn_of_lost_degrees(settings.out, **format, final_sh_degree(run->options));

  TrainCommand training(settings, std::move(*run), threads);
  if (auto done = training.to_end(); !done) return done;
  if (auto written = training.write_results(); !written) return written;
  return training.write_report();
}

/// A checkpoint brings every option but these.
bool stays_free_on_resume(const std::string& name) {
  const std::string_view free[] = {"data",    "out",  "float-output",     "resume", "threads",
                                   "backend", "json", "checkpoint-every", "help",   "holdout"};
  return std::ranges::find(free, name) != std::end(free);
}

}  // namespace

void add_train(CLI::App& app, Action& action) {
  auto settings = std::make_shared<TrainSettings>();
  CLI::App* command = app.add_subcommand("train", "Train a scene from posed images");
  command->footer(
      "DATA is a COLMAP folder (sparse/0 and images/), a folder with transforms.json or\n"
      "transforms_train.json, or a folder of photos or a video (then COLMAP finds the poses).\n"
      "Ctrl-C saves OUT.ckpt, from which --resume goes on exactly as if nothing had happened.\n"
      "Example: fluxgs train captures/garden -o garden.glb --downscale 2 --iterations 7000");
  const auto grouped = [](CLI::Option* option, const char* group) { return option->group(group); };
  constexpr const char *kFiles = "Files", *kRun = "Run";
  grouped(command->add_option("data", settings->data.folder, "the data set"), kFiles);
  grouped(command->add_option("-o,--out", settings->out,
                              "the scene to write: " + writable_extensions()),
          kFiles);
  grouped(command->add_option("--float-output", settings->float_output,
                              "also write the uncompressed scene, for example as .ply"),
          kFiles);
  grouped(command->add_option("--json", settings->report,
                              "write a report of the run as JSON (-: standard output)"),
          kFiles);
  grouped(command->add_option("--resume", settings->resume,
                              "continue from a checkpoint, with its options"),
          kFiles);
  grouped(command->add_option("--checkpoint-every", settings->checkpoint_every,
                              "iterations between saves of OUT.ckpt (0: never)"),
          kFiles)
      ->check(CLI::NonNegativeNumber);
  grouped(
      command->add_option("--preset", settings->preset, "set of defaults for all training options"),
      kRun)
      ->check(CLI::IsMember(preset_names()))
      ->capture_default_str();
  grouped(command->add_flag("--plan", settings->plan,
                            "print the schedule as a table, without training"),
          kRun);
  add_data_options(*command, settings->data);
  for (const char* name :
       {"--downscale", "--holdout", "--video-frames", "--background", "--threads"})
    grouped(command->get_option(name), kRun);
  grouped(command->add_option("--backend", settings->backend, "auto, cpu or cuda"), kRun)
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  add_method_options(*command, settings->method);
  show_groups(*command, {kFiles, kRun, kCommonOptions});
  command->callback([settings, command, &action] {
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() > 0) settings->given.insert(option->get_single_name());
      if (!settings->resume.empty() && option->count() > 0 &&
          !stays_free_on_resume(option->get_single_name()))
        throw CLI::ValidationError("--" + option->get_single_name(),
                                   "cannot be changed with --resume");
    }
    if (!settings->plan)
      for (const char* name : {"data", "--out"})
        if (command->get_option(name)->count() == 0) throw CLI::RequiredError(name);
    if (!settings->out.empty() && same_file(settings->float_output, settings->out))
      throw CLI::ValidationError("--float-output", "is the same file as --out");
    action = [settings] { return train(*settings); };
  });
}

}  // namespace fluxgs::cli
