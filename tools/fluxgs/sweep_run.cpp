#include "tools/fluxgs/sweep_run.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "tools/fluxgs/child_process.h"
#include "tools/fluxgs/command.h"
#include "tools/fluxgs/read_json.h"
#include "tools/fluxgs/sweep_rows.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Options = std::vector<std::string>;

/// A child's work, which is done when its product is there: JSON.
struct Step {
  std::string name = {};
  json meaning = {};       ///< what the product depends on, besides the steps before
  Options arguments = {};  ///< of the child
  fs::path product = {};
  bool prints = false;    ///< the product is what the child prints
  bool optional = false;  ///< a failure is something missing, not a failed run
};

constexpr const char *kTrain = "train", *kScore = "score of the compact scene",
                     *kFrames = "frame time";

const Options kWithFlip = {"--json", "--flip"};

Options joined(std::initializer_list<Options> parts) {
  Options all;
  for (const Options& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

fs::path checkpoint_of(const SweepRun& run) { return run.folder / "scene.glb.ckpt"; }

Step train_step(const SweepRun& run) {
  const fs::path report = run.folder / "train.json";
  const Options files = {"train",
                         run.data,
                         "-o",
                         (run.folder / "scene.glb").string(),
                         "--float-output",
                         (run.folder / "scene.ply").string(),
                         "--json",
                         report.string()};
  // So that little is lost with the power
  const Options options = merged_options({"--checkpoint-every", "1000"}, run.options);
  Step step{.name = kTrain, .meaning = run.meaning, .arguments = {}, .product = report};
  std::error_code ignored;
  if (fs::exists(checkpoint_of(run), ignored))
    step.arguments =
        joined({files,
                {"--resume", checkpoint_of(run).string()},
                picked_options(options, {"--threads", "--backend", "--checkpoint-every"})});
  else
    step.arguments =
        joined({files, {"--preset", run.preset, "--seed", fmt::format("{}", run.seed)}, options});
  return step;
}

std::vector<Step> measuring_steps(const SweepRun& run, const SweepMeasures& measures) {
  const Options data_options =
      picked_options(run.options, {"--downscale", "--background", "--threads"});
  const Options data = joined({{"--data", run.data}, data_options});
  const std::string stored = (run.folder / "scene.glb").string();
  const auto add = [&](std::string name, Options files, const Options& options, Step step) {
    step.name = std::move(name);
    step.meaning = options;
    step.arguments = joined({files, options, data});
    return step;
  };
  std::vector<Step> steps;
  steps.push_back(add(kScore, {"eval", stored}, measures.flip ? kWithFlip : Options{"--json"},
                      {.product = run.folder / "score.json", .prints = true, .optional = true}));
  if (measures.frames > 0)
    steps.push_back(add(kFrames, {"bench", stored},
                        {"--json", "--frames", fmt::format("{}", measures.frames)},
                        {.product = run.folder / "frames.json", .prints = true, .optional = true}));
  return steps;
}

/// What a folder remembers.
struct Record {
  std::string data_hash, version, build;
  json steps = json::object();  ///< name → {meaning, error: text or null}
};

std::string record_path(const SweepRun& run) { return (run.folder / "run.json").string(); }

Record read_record(const SweepRun& run) {
  const auto found = read_json(record_path(run));
  if (!found) return {};
  try {
    Record r{.data_hash = found->at("data_hash"),
             .version = found->at("version"),
             .build = found->at("build"),
             .steps = found->at("steps")};
    return r.steps.is_object() ? r : Record{};
  } catch (const json::exception&) {  // not ours, or an old one
    return {};
  }
}

Expected<void> write_record(const SweepRun& run, const Record& r) {
  return write_json(record_path(run), {{"data", run.data},
                                       {"data_hash", r.data_hash},
                                       {"version", r.version},
                                       {"build", r.build},
                                       {"preset", run.preset},
                                       {"options", run.options},
                                       {"seed", run.seed},
                                       {"steps", r.steps}});
}

/// How far a training's log says it is, of `total`.
std::optional<int> iteration_in(const fs::path& log, int total) {
  constexpr std::streamoff kTail = 2048;
  std::ifstream in(log, std::ios::binary | std::ios::ate);
  if (!in) return std::nullopt;
  const std::streamoff size = in.tellg();
  in.seekg(std::max<std::streamoff>(size - kTail, 0));
  const std::string tail{std::istreambuf_iterator<char>(in), {}};
  const std::size_t end = tail.rfind(fmt::format("/{} ", total));
  if (end == std::string::npos) return std::nullopt;
  const std::size_t before = tail.find_last_not_of("0123456789", end - 1);
  int iteration = 0;
  if (before == std::string::npos ||
      std::sscanf(tail.c_str() + before + 1, "%9d/", &iteration) != 1)
    return std::nullopt;
  return iteration;
}

/// The last error in a log that was `from` bytes long before, in one line.
std::string error_in(const fs::path& log, std::uintmax_t from, const ChildEnd& end) {
  if (end.signal != 0)
    return fmt::format("ended by signal {} ({})", end.signal, ::strsignal(end.signal));
  constexpr std::string_view kMark = "fluxgs: error: ";
  std::ifstream in(log, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(from));
  std::string last = fmt::format("ended with status {} and no word; see its log.txt", end.status);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(kMark)) last = line.substr(kMark.size());
  return last;
}

/// A run at work.
class Execution {
 public:
  Execution(const SweepRun& run, const SweepTools& tools) : run_(run), tools_(tools) {}

  RunOutcome to_end() {
    outcome_.state = RunState::finished;
    if (auto ok = open(); !ok) {
      give_up(ok.error().message());
      return outcome_;
    }
    bool goes_on = step(train_step(run_));
    for (const Step& s : measuring_steps(run_, tools_.measures)) goes_on = goes_on && step(s);
    if (goes_on) collect();
    outcome_.build = record_.build;
    return outcome_;
  }

 private:
  Expected<void> open() {
    std::error_code error;
    fs::create_directories(run_.folder, error);
    if (error) return fail(run_.folder.string(), "", "cannot be created: " + error.message());
    record_ = read_record(run_);
    const json trained = record_.steps.value(kTrain, json::object()).value("meaning", run_.meaning);
    if (record_.data_hash == run_.data_hash && record_.version == FLUXGS_VERSION &&
        trained == run_.meaning)
      return {};
    record_ = {.data_hash = run_.data_hash, .version = FLUXGS_VERSION, .build = {}};
    return put_aside();
  }

  bool has(const char* name) const {
    std::error_code ignored;
    return fs::exists(run_.folder / name, ignored);
  }

  /// What took long to make is not thrown away because something else is asked for now.
  Expected<void> put_aside() {
    if (!has("train.json") && !has("scene.glb.ckpt")) return {};
    fs::path other;
    std::error_code error;
    for (int i = 1; i == 1 || fs::exists(other, error); ++i)
      other = fmt::format("{}.old-{}", run_.folder.string(), i);
    fs::rename(run_.folder, other, error);
    if (!error) fs::create_directories(run_.folder, error);
    if (error) return fail(run_.folder.string(), "", "cannot be put aside: " + error.message());
    outcome_.remarks.push_back(
        "a run of other data, other options or another version was there and is put aside");
    return {};
  }

  void forget_measures() {
    for (const char* name : {kScore, kFrames}) record_.steps.erase(name);
    for (const char* name : {"score.json", "frames.json"}) remove(name);
  }
  void remove(const char* name) const {
    std::error_code ignored;
    fs::remove(run_.folder / name, ignored);
  }

  void give_up(std::string error) {
    outcome_.state = RunState::failed;
    outcome_.error = std::move(error);
  }

  /// Whether the run goes on.
  bool step(const Step& s) {
    const json known = record_.steps.value(s.name, json::object());
    const json meaning = known.value("meaning", json());
    // A score with FLIP is one without, too
    const bool same = meaning == s.meaning || (s.name == kScore && meaning == json(kWithFlip));
    const json error = known.value("error", json());
    // What failed because of options that mean nothing to the scene, such as --threads, may not now
    const bool same_words = known.value("options", json(run_.options)) == json(run_.options);
    if (same && same_words && error.is_string() && !tools_.retry) return tell_failure(s, error);
    if (same && error.is_null()) {
      if (is_done(s)) return true;
      if (has(s.product.filename().c_str()))
        outcome_.remarks.push_back(fmt::format("{} made again: files of it were damaged", s.name));
    }
    if (s.name == kScore && !has_test_views()) {
      outcome_.remarks.push_back("no PSNR and SSIM: the data set has no test images");
      return true;
    }
    return s.name == kTrain ? train(s) : run_step(s);
  }

  bool is_done(const Step& s) const {
    const auto product = read_json(s.product);
    return product && product->is_object() && (s.name != kTrain || has_whole_scene(*product));
  }

  /// Of the sizes that training wrote. The .ply, which nothing reads, may be gone.
  bool has_whole_scene(const json& report) const {
    return report.contains("bytes") && has_size("scene.glb", report.at("bytes")) &&
           (!has("scene.ply") || !report.contains("float_bytes") ||
            has_size("scene.ply", report.at("float_bytes")));
  }

  bool has_size(const char* name, const json& bytes) const {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(run_.folder / name, error);
    return !error && bytes == size;
  }

  bool has_test_views() const {
    const auto report = read_json(run_.folder / "train.json");
    return report && report->contains("psnr");
  }

  bool tell_failure(const Step& s, const std::string& error) {
    if (!s.optional) {
      give_up(error);
      return false;
    }
    outcome_.remarks.push_back(fmt::format("no {}: {}", s.name, error));
    return true;
  }

  /// Training, from a checkpoint if there is one. One that is named as the cause of a failure is of
  /// no use.
  bool train(const Step& s) {
    if (!has("scene.glb.ckpt")) record_.build = tools_build();
    forget_measures();
    const bool goes_on = run_step(s);
    if (goes_on || outcome_.error.starts_with(checkpoint_of(run_).string()))
      remove("scene.glb.ckpt");
    return goes_on;
  }

  std::string tools_build() const { return hash_of_file(tools_.program).value_or(""); }

  bool run_step(const Step& s) {
    outcome_.ran = true;
    if (tools_.interrupts.count() > 0) {
      outcome_.state = RunState::interrupted;
      return false;
    }
    const fs::path log = run_.folder / "log.txt";
    std::error_code ignored;
    fs::remove(s.product, ignored);  // or it would stand for the new one after an interruption
    record_.steps[s.name] = {{"meaning", s.meaning}, {"options", run_.options}, {"error", nullptr}};
    if (auto written = write_record(run_, record_); !written) {
      give_up(written.error().message());
      return false;
    }
    const std::uintmax_t from = fs::exists(log, ignored) ? fs::file_size(log, ignored) : 0;
    const fs::path partial = s.product.string() + ".part";
    const auto end = run_child({tools_.program, s.arguments, log, s.prints ? partial : fs::path()},
                               &tools_.interrupts, watch(s, log));
    if (end && end->success() && s.prints) fs::rename(partial, s.product, ignored);
    fs::remove(partial, ignored);
    return finish_step(s, end, log, from);
  }

  std::function<void()> watch(const Step& s, const fs::path& log) const {
    if (s.name != kTrain || !tools_.on_iteration) return {};
    return [this, log, calls = 0]() mutable {
      if (++calls % 20 != 0) return;
      tools_.on_iteration(iteration_in(log, run_.iterations).value_or(0));
    };
  }

  bool finish_step(const Step& s, const Expected<ChildEnd>& end, const fs::path& log,
                   std::uintmax_t from) {
    std::error_code ignored;
    const bool done = end && end->success() && fs::exists(s.product, ignored);
    const bool interrupted = !done && end && tools_.interrupts.count() > 0;
    std::string error;
    if (!done && !interrupted) error = end ? error_in(log, from, *end) : end.error().message();
    if (!error.empty()) record_.steps[s.name]["error"] = error;
    if (auto written = write_record(run_, record_); !written) {
      give_up(written.error().message());
      return false;
    }
    if (interrupted) outcome_.state = RunState::interrupted;
    if (!error.empty()) return tell_failure(s, error);
    return done;
  }

  /// The numbers of a finished run.
  void collect() {
    if (const auto report = read_json(run_.folder / "train.json")) collect_training(*report);
    if (const auto score = read_json(run_.folder / "score.json")) {
      take(*score, "/psnr", "stored_psnr");
      take(*score, "/ssim", "stored_ssim");
      take(*score, "/flip", "stored_flip");
    }
    if (tools_.measures.frames > 0)
      if (const auto frames = read_json(run_.folder / "frames.json")) collect_frames(*frames);
    if (!outcome_.values.contains("ply_bytes")) {  // of a run of before it was written down
      std::error_code error;
      const auto size = fs::file_size(run_.folder / "scene.ply", error);
      if (!error) outcome_.values["ply_bytes"] = static_cast<double>(size);
    }
  }

  void take(const json& from, const char* key, const char* as) {
    const json::json_pointer at(key);
    if (from.contains(at) && from.at(at).is_number())
      outcome_.values[as] = from.at(at).get<double>();
  }

  void collect_frames(const json& frames) {
    take(frames, "/sort_to_display_ms/median", "frame_ms");
    outcome_.remarks.push_back(fmt::format(
        "frame times: projecting, sorting and drawing, medians of {} frames of {}x{}, {}",
        frames.at("frames").get<int>(), frames.at("size").at(0).get<int>(),
        frames.at("size").at(1).get<int>(), frames.at("gl_renderer").get<std::string>()));
  }

  void collect_training(const json& report) {
    take(report, "/psnr_before_compression", "psnr");
    take(report, "/ssim_before_compression", "ssim");
    take(report, "/splats", "splats");
    take(report, "/bytes", "stored_bytes");
    take(report, "/float_bytes", "ply_bytes");
    take(report, "/seconds", "seconds");
    take(report, "/cpu_seconds", "cpu_seconds");
    take(report, "/threads", "threads");
    if (report.contains("networks_error"))
      outcome_.remarks.push_back("stored without networks: " +
                                 report.at("networks_error").get<std::string>());
    if (report.contains("psnr")) collect_curves(report.at("curves"));
  }

  /// The test images' PSNR over the training, and the effect of the SH reduction on it.
  void collect_curves(const json& curves) {
    for (const json& phase : curves.at("phases"))
      if (phase.at("phase") == "SH reduction") {
        const auto test = phase.at("test_psnr").get<std::array<double, 2>>();
        outcome_.values["sh_reduction_psnr"] = test[1] - test[0];
      }
    outcome_.curve = curves.at("psnr");
  }

  const SweepRun& run_;
  const SweepTools& tools_;
  Record record_;
  RunOutcome outcome_;
};

}  // namespace

RunOutcome execute_run(const SweepRun& run, const SweepTools& tools) {
  try {
    return Execution(run, tools).to_end();
  } catch (const json::exception& error) {  // of a file in its folder that others have written
    return {.state = RunState::failed,
            .error = fmt::format("{}: {}", run.folder.string(), error.what())};
  }
}

}  // namespace fluxgs::cli
