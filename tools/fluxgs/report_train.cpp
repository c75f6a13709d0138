// fluxgs report train: what each part of the method is worth.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <numeric>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "fluxgs/io/file.h"
#include "tools/fluxgs/command.h"
#include "tools/fluxgs/console.h"
#include "tools/fluxgs/find_program.h"
#include "tools/fluxgs/flip.h"
#include "tools/fluxgs/report.h"
#include "tools/fluxgs/sweep.h"
#include "tools/fluxgs/sweep_plot.h"
#include "trainer/model/options.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;

struct TrainReport {
  std::vector<std::string> data;  // and what came after "--", until it is taken apart
  std::string out, preset, unused;
  std::vector<std::string> only, common, known;
  int seeds = 3;
  SweepMeasures measures;
  bool retry = false, list = false, as_json = false;
};

/// The command again, as one would type it.
std::string command_of(const TrainReport& s) {
  std::vector<std::string> words{"fluxgs", "report", "train"};
  const auto add = [&](std::initializer_list<std::string> more) {
    for (const std::string& word : more) words.push_back(shell_quoted(word));
  };
  for (const std::string& folder : s.data) add({folder});
  add({"-o", s.out});
  if (!s.only.empty()) add({"--only", fmt::format("{}", fmt::join(s.only, ","))});
  if (!s.preset.empty()) add({"--preset", s.preset});
  if (!s.known.empty()) add({"--known", fmt::format("{}", fmt::join(s.known, ","))});
  const SweepMeasures usual;
  if (s.seeds != TrainReport().seeds) add({"--seeds", fmt::format("{}", s.seeds)});
  if (s.measures.frames != usual.frames) add({"--frames", fmt::format("{}", s.measures.frames)});
  if (!s.common.empty()) add({"--"});
  for (const std::string& word : s.common) add({word});
  return fmt::format("{}", fmt::join(words, " "));
}

void list_rows(const std::vector<SweepRow>& rows) {
  for (const SweepRow& row : rows)
    fmt::print("{:<15} {:<22} --preset {} {}\n", row.group, row.name, row.preset,
               fmt::join(row.options, " "));
}

/// What is not measured at all.
std::vector<std::string> general_notes(const TrainReport& s, const SweepTable& table,
                                       const Expected<void>& flip) {
  std::vector<std::string> notes{
      "LPIPS is missing: its packages need PyTorch and download the weights of a network"};
  const auto lacks = [&](const char* key) {
    return std::ranges::none_of(table.outcomes,
                                [&](const RunOutcome& o) { return o.values.contains(key); });
  };
  if (!flip && lacks("stored_flip")) notes.push_back("FLIP is missing: " + flip.error().message());
  if (s.measures.frames == 0 && lacks("frame_ms"))
    notes.push_back("frame times are missing: --frames 0");
  return notes;
}

Expected<void> write_text(const fs::path& path, const std::string& text) {
  return write_file_atomic(path, std::as_bytes(std::span(text)));
}

/// Images of each group that has a number to show; returns their names. One that cannot be drawn
/// costs neither the others nor the numbers.
std::vector<std::string> write_images(const TrainReport& s, const SweepTable& table) {
  std::vector<std::string> names;
  if (!find_program("gnuplot")) {
    spdlog::warn("warning: no images: gnuplot is not installed (tools/setup has it)");
    return names;
  }
  const auto draw = [&](const std::string& name, const Plot& plot) {
    if (!has_points(plot)) return;
    const std::string file = name + ".png";
    if (const auto drawn = write_plot((fs::path(s.out) / file).string(), plot); drawn)
      names.push_back(file);
    else
      spdlog::warn("warning: {}", drawn.error().message());
  };
  for (const SweepGroup& group : sweep_groups()) {
    draw(group.name, sweep_plot(table, group));
    draw(group.name + "-curves", sweep_curves(table, group));
  }
  return names;
}

Expected<void> write_results(const TrainReport& s, const SweepTable& table) {
  const fs::path out = s.out;
  const std::vector<std::string> images = write_images(s, table);
  if (auto ok = write_text(out / "report.md", sweep_markdown(table, images)); !ok) return ok;
  return write_json((out / "report.json").string(), sweep_json(table));
}

/// Of a sweep whose report is written. The first failure stands for all where nothing succeeded.
Expected<void> judge(const TrainReport& s, const SweepTable& table) {
  const int all = static_cast<int>(table.outcomes.size());
  const int finished = table.count(RunState::finished), failed = table.count(RunState::failed);
  if (table.interrupted)
    return fail(
        "", "interrupted",
        fmt::format("{} of {} runs are finished; go on with: {}", finished, all, command_of(s)));
  if (finished == 0)
    return fail(s.out, "",
                fmt::format("none of the {} runs succeeded; the first failed: {}", all,
                            table.outcomes.front().error));
  if (failed > 0)
    return fail(
        (fs::path(s.out) / "report.md").string(), "",
        fmt::format("{} of {} runs failed; the report says why, and has the others; --retry "
                    "tries again",
                    failed, all));
  return {};
}

Expected<void> report(const TrainReport& s) {
  auto rows = chosen_sweep_rows(s.only, s.preset);
  if (!rows) return std::unexpected(rows.error());
  if (s.list) {
    list_rows(*rows);
    return {};
  }
  const Expected<void> flip = check_flip();
  SweepSettings settings{.data = s.data,
                         .out = s.out,
                         .rows = std::move(*rows),
                         .seeds = std::vector<std::uint64_t>(static_cast<std::size_t>(s.seeds)),
                         .common = s.common,
                         .measures = s.measures,
                         .retry = s.retry,
                         // This very program, even if another was built in its place meanwhile
                         .program = "/proc/self/exe"};
  for (const std::string& path : s.known)
    if (auto added = settings.known.add(path); !added) return added;
  std::iota(settings.seeds.begin(), settings.seeds.end(), 1);
  settings.measures.flip = flip.has_value();
  auto table = run_sweep(settings);
  if (!table) return std::unexpected(table.error());
  table->command = command_of(s);
  std::ranges::move(general_notes(s, *table, flip), std::back_inserter(table->notes));
  if (auto written = write_results(s, *table); !written) return written;
  if (!table->interrupted && table->count(RunState::finished) > 0) {
    if (s.as_json)
      print_json(sweep_json(*table));
    else
      fmt::print("{}", sweep_markdown(*table));
  }
  return judge(s, *table);
}

/// Everything from the first option on came after "--" and is for `train`.
void take_apart(TrainReport& s) {
  const auto first =
      std::ranges::find_if(s.data, [](const std::string& word) { return word.starts_with('-'); });
  s.common.assign(first, s.data.end());
  s.data.erase(first, s.data.end());
  for (const std::string& word : s.common) {
    constexpr std::string_view kOwn[] = {"--out",    "--json", "--resume", "--float-output",
                                         "--preset", "--seed", "-h",       "--help"};
    if (word.starts_with("-o") ||
        std::ranges::count(kOwn, std::string_view(word).substr(0, word.find('='))) > 0)
      throw CLI::ValidationError(word, "is not for all runs; the report sets it for each");
  }
  if (s.list) return;
  if (s.data.empty()) throw CLI::RequiredError("data");
  if (s.out.empty()) throw CLI::RequiredError("--out");
}

void add_options(CLI::App& command, TrainReport& s) {
  command.add_option("data", s.data, "the data sets");
  // Never gets a value: the one before takes everything. But without it CLI11 thinks the command
  // complete at "--" and gives the rest to its parent.
  command.add_option("options", s.unused, "after \"--\": options of train for every run");
  command.add_option("-o,--out", s.out, "folder for the runs and the report");
  command.add_option("--only", s.only, "groups or rows, separated by commas (default: all)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--preset", s.preset, "what rows change, instead of their own preset");
  command.add_option("--seeds", s.seeds, "runs of each row")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--frames", s.measures.frames, "frames to time (0: none)")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
  command
      .add_option("--known", s.known,
                  "reports (.json) of other sweeps, or folders of such, whose runs are taken over")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_flag("--retry", s.retry, "also the runs that failed before");
  command.add_flag("--list", s.list, "print the rows and do nothing");
  command.add_flag("--json", s.as_json, "print one JSON object instead of Markdown");
}

}  // namespace

void add_report_train(CLI::App& app, Action& action) {
  auto s = std::make_shared<TrainReport>();
  CLI::App* command = app.add_subcommand(
      "train", "What each part of the method is worth: rows of options, several seeds");
  command->footer(
      "Writes report.md, report.json and images of each group to OUT, and every run to\n"
      "OUT/SCENE/ROW/seed-N. What is finished there is not run again; Ctrl-C saves, and the same\n"
      "command goes on. A run that fails leaves the others be; the exit status is then 1.\n"
      "The report is of the rows of this call; --only leaves other runs be, but not their report.\n"
      "Rows of a call that mean the same share their runs; --known takes over what other calls\n"
      "have finished, perhaps on other machines.\n"
      "Frame times and minutes mean something on an idle machine only.\n"
      "Example: fluxgs report train captures/garden -o sweep --only presets,cameras "
      "-- --iterations 7000 --downscale 2");
  add_options(*command, *s);
  command->callback([s, &action] {
    take_apart(*s);
    action = [s] { return report(*s); };
  });
}

}  // namespace fluxgs::cli
