// fluxgs train: images in, a scene file out.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/train_run.h"
#include "tools/fluxgs/commands/training.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/terminal/files.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/run_lock.h"
#include "trainer/train/checkpoint.h"

namespace fluxgs::cli {
namespace {

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

/// A checkpoint of another training may hold days of work; only its own may be replaced.
Expected<void> check_checkpoint(const TrainSettings& settings) {
  const std::string path = checkpoint_of(settings);
  std::error_code ignored;
  if (settings.force || settings.checkpoint_every.never() ||
      !std::filesystem::exists(path, ignored))
    return {};
  if (!is_checkpoint(path)) return check_overwrite(path, false);
  return fail(path, "",
              fmt::format("holds a training; --resume {} goes on with it, --force starts anew",
                          typed(path)));
}

/// Nothing that is there already is replaced unasked, but by more of the same training.
Expected<void> check_all_overwrites(const TrainSettings& settings) {
  if (same_file(settings.resume, checkpoint_of(settings))) return {};
  if (auto ok = check_checkpoint(settings); !ok) return ok;
  std::vector<std::string> paths = {settings.out, settings.float_output, settings.report};
  if (settings.preview_every > 0) paths.push_back(preview_folder(settings));
  for (const std::string& path : paths)
    if (!path.empty() && path != "-")
      if (auto ok = check_overwrite(path, settings.force); !ok) return ok;
  return {};
}

/// Everything that is to be written can be; a report in the data set would be taken for poses.
Expected<void> check_outputs(const TrainSettings& settings) {
  if (auto ok = check_all_overwrites(settings); !ok) return ok;
  if (auto ok = check_writable(settings.out); !ok) return ok;
  if (auto ok = check_float_output(settings); !ok) return ok;
  if (settings.report.empty() || settings.report == "-") return {};
  if (std::filesystem::path(settings.report).extension() != ".json" ||
      lies_in(settings.report, settings.data.folder))
    return fail(settings.report, "--json",
                "expected a name that ends in .json, outside of the data set");
  return check_writable(settings.report);
}

/// Points that a training begins with are not overwritten by its result.
Expected<void> check_inputs_stay(const TrainSettings& settings, const Dataset& data) {
  for (const std::string& path : {settings.out, settings.float_output})
    if (same_file(path, data.points_file))
      return fail(path, "", "holds the points of the data set, expected another name to write to");
  return {};
}

/// --plan: the schedule of the options, without data. With --json the options themselves.
Expected<void> print_plan(const TrainSettings& settings) {
  const auto options = settings.resume.empty() ? options_from(settings) : resumed_options(settings);
  if (!options) return std::unexpected(options.error());
  const Schedule schedule = plan_schedule(*options);
  return give_report(settings.report, {{"options", options_json(schedule.options)}},
                     [&] { fmt::print("{}", plan_table(schedule)); });
}

Expected<void> train(TrainSettings settings) {
  if (settings.plan) return print_plan(settings);
  if (settings.backend == "cuda")
    return fail("", "--backend cuda", "this build has no CUDA backend; use --backend cpu");
  for (const std::string& file : {settings.out, settings.float_output, settings.report})
    if (auto ok = check_no_folder(file); !ok) return ok;
  const auto format = scene_format_for(settings.out);
  if (!format) return std::unexpected(format.error());
  if (auto ok = check_outputs(settings); !ok) return ok;

  const auto lock = RunLock::take(settings.out);
  if (!lock) return std::unexpected(lock.error());
  const Threads threads(settings.data.threads);
  auto run = settings.resume.empty() ? new_run(settings, threads) : resume_run(settings);
  if (!run) return std::unexpected(run.error());
  if (auto ok = check_inputs_stay(settings, run->data); !ok) return ok;
  warn_of_lost_degrees(settings.out, **format, final_sh_degree(run->options));
  if (const auto other = scene_format_for(settings.float_output); other)
    warn_of_lost_degrees(settings.float_output, **other, final_sh_degree(run->options));

  TrainWork training(settings, std::move(*run), threads);
  if (auto done = training.to_end(); !done) return done;
  if (auto written = training.write_results(); !written) return written;
  training.say_what_next();
  return {};
}

}  // namespace

void add_train(CLI::App& app, Action& action) {
  auto settings = std::make_shared<TrainSettings>();
  CLI::App* command = app.add_subcommand("train", "Train a scene from posed images");
  command->footer(
      "DATA is a COLMAP folder (sparse/0 and images/), a folder with transforms.json or\n"
      "transforms_train.json, or a folder of photos or a video (then COLMAP finds the poses).\n"
      "Ctrl-C saves OUT.ckpt, from which --resume goes on exactly as if nothing had happened.\n"
      "It is saved every 10 minutes, too, and at the end, to train on with more --iterations.\n"
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
  // Its name in version 0.1.0
  grouped(command->add_option("--exact", settings->float_output), "");
  grouped(command->add_option("--json", settings->report,
                              "write a report of the run as JSON (-: standard output)"),
          kFiles);
  grouped(
      command->add_option("--resume", settings->resume,
                          "continue from a checkpoint, with its options; with more --iterations "
                          "also a finished training"),
      kFiles);
  grouped(command->add_option("--checkpoint-every", settings->checkpoint_every_text,
                              "time (90s, 10m, 1h) or iterations between saves of OUT.ckpt, which "
                              "stays at the end (0: none)"),
          kFiles)
      ->type_name("TIME")
      ->capture_default_str()
      ->each([settings](const std::string& text) {
        const auto interval = parse_checkpoint_interval(text);
        if (!interval) throw CLI::ValidationError(interval.error().message());
        settings->checkpoint_every = *interval;
      });
  grouped(command->add_flag("--force", settings->force, "replace files that are there already"),
          kFiles);
  grouped(command->add_flag("--preview", settings->preview,
                            "show the growing scene in a window (fluxgs view)"),
          kRun);
  grouped(command->add_option("--preview-every", settings->preview_every,
                              "iterations between pictures of one view, in OUT.preview/"),
          kRun)
      ->check(whole_in(1, 1'000'000'000));
  grouped(command->add_option("--preset", settings->preset,
                              "set of defaults for all training options; those shown are flux's"),
          kRun)
      ->check(CLI::IsMember(preset_names()))
      ->capture_default_str();
  grouped(command->add_flag("--plan", settings->plan,
                            "print the schedule as a table, without training"),
          kRun);
  add_data_options(*command, settings->data);
  for (const char* name : {"--downscale", "--holdout", "--video-frames", "--photo-memory",
                           "--background", "--threads"})
    grouped(command->get_option(name), kRun);
  grouped(command->add_option("--backend", settings->backend, "auto, cpu or cuda"), kRun)
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  add_method_options(*command, settings->method);
  show_groups(*command, {kFiles, kRun, kCommonOptions});
  command->callback([settings, command, &action] {
    for (const CLI::Option* option : command->get_options())
      if (option->count() > 0) settings->given.insert(option->get_single_name());
    if (!settings->plan)
      for (const char* name : {"data", "--out"})
        if (command->get_option(name)->count() == 0) throw CLI::RequiredError(name);
    if (settings->given.contains("exact") && settings->given.contains("float-output"))
      throw CLI::ValidationError("--exact", "is the old name of --float-output; give one of them");
    if (!settings->out.empty() && same_file(settings->float_output, settings->out))
      throw CLI::ValidationError("--float-output", "is the same file as --out");
    action = [settings] { return train(*settings); };
  });
}

}  // namespace fluxgs::cli
