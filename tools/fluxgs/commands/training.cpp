#include "tools/fluxgs/commands/training.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <opencv2/core/version.hpp>

#include "fluxgs/io/scene.h"
#include "fluxgs/sanitize.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/conversion_losses.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/peak_memory.h"
#include "trainer/compress/compression.h"
#include "trainer/train/checkpoint.h"
#include "trainer/train/evaluate.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

/// A checkpoint before an event, where the last one is older.
constexpr double kEventCheckpointAge = 20;  // seconds

std::optional<std::uintmax_t> size_of(const std::string& path) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  return error ? std::nullopt : std::optional(bytes);
}

/// Null if somebody took the file away.
json json_size_of(const std::string& path) {
  const auto bytes = size_of(path);
  return bytes ? json(*bytes) : json();
}

/// Work after the last iteration, and the measuring of the test views meanwhile.
LaterWork later_work(const TrainSettings& settings, const Trainer& trainer) {
  const auto tests = static_cast<double>(trainer.data.test.size());
  const std::size_t views = trainer.data.train.size();
  const double scored = tests > 0 ? tests : static_cast<double>(views);
  LaterWork later{.measuring_renders = 20 * tests};
  const bool compact = (*scene_format_for(settings.out))->name == "glb";
  if (compact) {
    later.storing = compact_search_work(views, trainer.options.iterations);
    later.storing.renders += static_cast<double>(views);
    later.storing.files += 1;
  }
  later.storing.renders += 3 * scored;  // the score, of what was trained and of what was stored
  return later;
}

std::string shown(const std::string& path) { return one_line(path, std::string::npos); }

/// True where one is more than half as much again as the other.
bool much_else(double now, double before) {
  return std::max(now, before) > 1.5 * std::min(now, before);
}

}  // namespace

TrainWork::TrainWork(const TrainSettings& settings, Run run, const Threads& threads)
    : settings_(settings),
      run_(std::move(run)),
      threads_(threads),
      first_(run_.state.iteration),
      trainer_(run_.data, run_.options, std::move(run_.state), threads, profiler_),
      preview_(settings_, run_.data),
      log_(run_.options.iterations),
      estimate_(trainer_, later_work(settings_, trainer_)) {
  set_interrupt_lines("stopping after this iteration with a checkpoint");
}

/// The second line names the checkpoint that is there by then.
void TrainWork::set_interrupt_lines(const std::string& first) {
  const std::string again =
      saved_iteration_ ? fmt::format("the checkpoint of iteration {} is kept", *saved_iteration_)
                       : "no checkpoint has been saved yet";
  interrupts_.set_lines(fmt::format("fluxgs: {}; again to quit at once ({})", first, again),
                        saved_iteration_ ? fmt::format("fluxgs: quit. {}",
                                                       how_to_resume(settings_, *saved_iteration_))
                                         : "fluxgs: quit without a checkpoint");
}

Expected<void> TrainWork::to_end() {
  Progress progress("it", run_.options.iterations, first_);
  while (!trainer_.done())
    if (auto ok = step(progress); !ok) return ok;
  progress.finish(trainer_.state.iteration);
  make_report();
  return {};
}

/// `where`: "iteration 300".
Expected<void> TrainWork::interrupted(const Expected<void>& saved, const std::string& where) const {
  if (!saved) return saved;
  if (!saved_iteration_) return fail("", "interrupted at " + where, "no checkpoint was saved");
  return fail("", "interrupted at " + where, how_to_resume(settings_, *saved_iteration_));
}

Expected<void> TrainWork::save() {
  const HoldInterrupts hold;
  const double before = wall_seconds();
  auto saved = save_checkpoint(checkpoint_of(settings_), settings_, run_, history(), trainer_);
  saved_at_ = wall_seconds();
  saving_seconds_ += saved_at_ - before;
  ++saves_;
  if (saved) {
    saved_iteration_ = trainer_.state.iteration;
    set_interrupt_lines("stopping after this iteration with a checkpoint");
  }
  return saved;
}

void TrainWork::save_if_due(bool due) {
  if (!due || saved_iteration_ == trainer_.state.iteration) return;
  if (const auto saved = save(); !saved)
    spdlog::warn("warning: no checkpoint at iteration {}: {}", trainer_.state.iteration,
                 saved.error().message());
}

Expected<void> TrainWork::step(Progress& progress) {
  const Phase* event = trainer_.event_at(trainer_.state.iteration + 1);
  if (event != nullptr) {
    // A crash within an event that takes long should not lose much before it
    const bool old = wall_seconds() - saved_at_ > kEventCheckpointAge;
    save_if_due(!settings_.checkpoint_every.never() && old);
    trainer_.progress = show_work(event->name());
  }
  const double begun = wall_seconds();
  const IterationReport done = trainer_.step();
  trainer_.progress = {};
  estimate_.add(wall_seconds() - begun);
  const int i = trainer_.state.iteration;

  const std::size_t splats = trainer_.state.parameters.size();
  log_.add(i, done, splats);
  preview_.update(trainer_);
  if (log_.psnr_is_due(i)) log_.measure_psnr(i, trainer_, run_.data.test);
  smooth_loss_ = smooth_loss_ > 0 ? 0.98 * smooth_loss_ + 0.02 * done.loss : done.loss;
  if (progress.due())
    progress.update(i, fmt::format("{} splats  loss {:.4f}", splats, smooth_loss_),
                    estimate_.seconds_left());
  say_expected();
  if (splats == 0)
    return fail(settings_.data.folder, fmt::format("iteration {}", i),
                "all splats were pruned: the poses probably do not match the images");
  if (interrupts_.any()) return interrupted(save(), fmt::format("iteration {}", i));
  save_if_due(settings_.checkpoint_every.is_due(wall_seconds() - saved_at_, i));
  return {};
}

/// Says what the whole run will take, after the first seconds and again when that has changed much.
void TrainWork::say_expected() {
  constexpr double kEvery = 5;  // seconds
  constexpr int kLeast = 10;    // iterations
  const double passed = wall_seconds() - start_;
  if (passed < estimated_at_ + kEvery || trainer_.state.iteration - first_ < kLeast) return;
  estimated_at_ = passed;
  const RunEstimate::Forecast to_come = estimate_.forecast();
  const Needs needs{passed + to_come.seconds,
                    static_cast<double>(estimate_.memory_of(to_come.splats))};
  if (said_ && !much_else(needs.seconds, said_->seconds) && !much_else(needs.memory, said_->memory))
    return;
  if (isatty(STDERR_FILENO)) say("\r\x1b[K");
  spdlog::info(
      "expected{}: {} in all, compression included; about {:.0f} splats at most, {} of "
      "memory",
      said_ ? " now" : "", duration(needs.seconds), to_come.splats,
      needs.memory < 1e9 ? fmt::format("{:.0f} MB", needs.memory / 1e6)
                         : fmt::format("{:.1f} GB", needs.memory / 1e9));
  if (!expected_) expected_ = needs;
  said_ = needs;
}

/// History of the iterations up to now, without the time of measuring them.
TrainHistory TrainWork::history() const {
  if (whole_) return *whole_;
  return joined(run_.history, {wall_seconds() - start_ - log_.measuring_seconds(),
                               cpu_seconds() - cpu_start_ - log_.measuring_cpu_seconds(),
                               trainer_.rejected_gradients(),
                               {profiler_.entries().begin(), profiler_.entries().end()},
                               {profiler_.cpu_entries().begin(), profiler_.cpu_entries().end()},
                               log_.to_json()});
}

void TrainWork::make_report() {
  whole_ = history();
  const TrainHistory& all = *whole_;
  const int steps = std::max(trainer_.state.iteration, 1);
  const auto ms_per_iteration = [steps](const std::map<std::string, double>& seconds) {
    json ms = json::object();
    for (const auto& [name, all_seconds] : seconds) ms[name] = 1e3 * all_seconds / steps;
    return ms;
  };
  json rates = all.curves.at("iterations_per_second");
  if (rates.empty()) rates = {0.0};
  report_ = {
      {"data", settings_.data.folder},
      {"out", settings_.out},
      {"float_output", settings_.float_output.empty() ? json() : json(settings_.float_output)},
      {"checkpoint_every", settings_.checkpoint_every_text},
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
      {"stages", ms_per_iteration(all.stages)},
      {"stages_cpu", ms_per_iteration(all.stages_cpu)},
      {"curves", all.curves},
      {"versions",
       {{"fluxgs", FLUXGS_VERSION}, {"opencv", CV_VERSION}, {"compiler", __VERSION__}}}};
}

/// A result; standard output is the report's where that goes there.
void TrainWork::tell(const std::string& line) const {
  if (settings_.report == "-")
    say(line);
  else
    fmt::print("{}", line);
}

/// The error of a result that could not be written; the training itself is saved.
Expected<void> TrainWork::keep_training(const Error& error) {
  Expected<void> saved;
  if (saved_iteration_ != trainer_.state.iteration) saved = save();
  if (saved)
    return fail(error.file, error.field,
                error.what + ". " + how_to_resume(settings_, trainer_.state.iteration));
  if (const auto elsewhere = save_elsewhere())
    return fail(error.file, error.field,
                fmt::format("{}. The training is saved as {}. Resume with: {}", error.what,
                            *elsewhere, resume_command(settings_, *elsewhere)));
  return fail(error.file, error.field,
              error.what + "; the training cannot be saved either: " + saved.error().message());
}

/// A checkpoint in another folder, where the disk of the result is full or gone.
std::optional<std::string> TrainWork::save_elsewhere() {
  namespace fs = std::filesystem;
  const HoldInterrupts hold;
  std::error_code ignored;
  const fs::path name = fs::path(checkpoint_of(settings_)).filename();
  for (const fs::path& folder : {fs::current_path(ignored), fs::temp_directory_path(ignored)}) {
    const fs::path path = folder / name;
    if (folder.empty() || fs::exists(path, ignored)) continue;
    if (save_checkpoint(path.string(), settings_, run_, history(), trainer_)) return path.string();
  }
  return std::nullopt;
}

Expected<StoredScene> TrainWork::store() {
  auto stored = store_scene(trainer_, run_.data.train, threads_,
                            {show_work("storing"), [this] { return interrupts_.any(); }});
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

/// Options for writers: the start view is one of the photos.
WriteOptions TrainWork::from_start() const {
  WriteOptions options;
  options.start = initial_view_of(run_.data.train);
  return options;
}

/// Writes the trained scene in the format of the name and says what that does not hold. Returns
/// what the file holds; nothing for a .ply, which holds all of it.
Expected<std::optional<SplatCloud>> TrainWork::write_trained(const std::string& path) const {
  const HoldInterrupts hold;
  const WriteOptions options = from_start();
  SceneFile trained;
  trained.cloud = trainer_.cloud();
  trained.start = options.start;
  if (auto written = write_scene(path, trained.cloud, options); !written)
    return std::unexpected(written.error());
  if ((*scene_format_for(path))->name == "ply") return std::nullopt;
  auto stored = read_scene(path);
  if (!stored) return std::unexpected(stored.error());
  for (const std::string& lost : lost_parts(trained, *stored))
    spdlog::warn("warning: {}: {}", shown(path), lost);
  return std::move(stored->cloud);
}

/// Writes a compact .glb or another format. Returns the scene that the file holds where it is not
/// the trainer's to the bit and there are images to compare it with.
Expected<std::optional<SplatCloud>> TrainWork::write_out() {
  const std::string_view format = (*scene_format_for(settings_.out))->name;
  if (format == "glb") {
    const double start = wall_seconds(), cpu_start = cpu_seconds();
    auto stored = store();
    if (!stored) return std::unexpected(stored.error());
    report_["storing"] = {{"seconds", wall_seconds() - start},
                          {"cpu_seconds", cpu_seconds() - cpu_start}};
    const HoldInterrupts hold;
    const auto bytes = write_glb(settings_.out, stored->file, initial_view_of(run_.data.train));
    if (!bytes) return std::unexpected(bytes.error());
    report_["bytes"] = *bytes;
    return std::move(stored->cloud);
  }
  auto stored = write_trained(settings_.out);
  if (stored) report_["bytes"] = json_size_of(settings_.out);
  return stored;
}

/// Scores the trainer's scene and, if it is another, the one in the file: against the test views,
/// or against the training views where all images are trained on.
Expected<void> TrainWork::score(const std::optional<SplatCloud>& stored) {
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

Expected<void> TrainWork::write_scene_and_score() {
  const auto stored = write_out();
  if (!stored) return std::unexpected(stored.error());
  return score(*stored);
}

/// --float-output, if there is one.
Expected<void> TrainWork::write_float_output() {
  if (settings_.float_output.empty()) return {};
  if (const auto written = write_trained(settings_.float_output); !written)
    return std::unexpected(written.error());
  report_["float_bytes"] = json_size_of(settings_.float_output);
  return {};
}

/// A densification at most doubles the splats, and a short run has few of them.
void TrainWork::warn_of_missed_target() const {
  const std::uint64_t target = run_.options.target_splats;
  const std::size_t splats = trainer_.state.parameters.size();
  if (static_cast<double>(splats) < 0.99 * static_cast<double>(target))
    spdlog::warn(
        "warning: --target-splats {}: there are only {}; more --iterations allow more growth",
        target, splats);
}

Expected<void> TrainWork::write_results() {
  save_if_due(!settings_.checkpoint_every.never());
  set_interrupt_lines("stopping");
  auto written = write_scene_and_score();
  if (!written && interrupts_.any()) {
    Expected<void> saved;
    if (saved_iteration_ != trainer_.state.iteration) saved = save();
    return interrupted(saved, "the storing of the scene");
  }
  if (!written) return keep_training(written.error());
  auto floats = write_float_output();
  report_["checkpoints"] = {{"saved", saves_}, {"seconds", saving_seconds_}};
  report_["total_seconds"] = run_.history.seconds + wall_seconds() - start_;
  report_["peak_memory_bytes"] = peak_memory();
  if (expected_)
    report_["expected"] = {{"seconds", expected_->seconds},
                           {"seconds_taken", wall_seconds() - start_},
                           {"peak_memory_bytes", expected_->memory}};
  tell(fmt::format("{}: {} splats, {} bytes, {:.1f} s\n", shown(settings_.out),
                   trainer_.state.parameters.size(), report_["bytes"].dump(),
                   report_["total_seconds"].get<double>()));
  warn_of_missed_target();
  if (auto reported = give_report(settings_.report, report_, [] {}); !reported) return reported;
  return floats ? Expected<void>() : keep_training(floats.error());
}

void TrainWork::say_what_next() {
  interrupts_.ignore();
  const std::string out = typed(settings_.out);
  const bool compact = (*scene_format_for(settings_.out))->name == "glb";
  std::string lines = fmt::format("Look at it:       fluxgs view {}\n", out);
  if (compact) lines += "On a phone:       send the file there and open it with the app Flux-GS\n";
  if (!settings_.float_output.empty())
    lines += fmt::format("Other programs:   open {}\n", shown(settings_.float_output));
  else if (compact)
    lines += fmt::format("Other programs:   fluxgs convert {} scene.ply (or .spz, .splat)\n", out);
  const auto bytes = size_of(checkpoint_of(settings_));
  if (bytes && saved_iteration_ == trainer_.state.iteration)
    lines += fmt::format(
        "Train it further: {} --iterations {}\n"
        "                  (it gets no new splats; a much longer training is better begun anew. "
        "{:.1f} MB; delete it otherwise)\n",
        resume_command(settings_, checkpoint_of(settings_)), 2 * trainer_.state.iteration,
        static_cast<double>(*bytes) / 1e6);
  if (run_.options.render.background != glm::dvec3(0))
    lines += fmt::format(
        "A scene file has no background: eval, render and view need --background {}, too\n",
        fmt::join(settings_.data.background, ","));
  std::fflush(stdout);  // the results come first
  say(lines);
}

}  // namespace fluxgs::cli
