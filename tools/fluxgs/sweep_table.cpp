#include "tools/fluxgs/sweep_table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fluxgs/sanitize.h"
#include "tools/fluxgs/report.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;
using Statistics = std::function<Statistic(std::size_t row, const char* key)>;

const char* name_of(RunState state) {
  switch (state) {
    case RunState::finished:
      return "finished";
    case RunState::failed:
      return "failed";
    case RunState::interrupted:
      return "interrupted";
    case RunState::waiting:
      break;
  }
  return "waiting";
}

json to_json(const Statistic& s) {
  return {{"mean", finite_or_null(s.mean)},
          {"deviation", finite_or_null(s.deviation)},
          {"count", s.count}};
}

json statistics_json(const Statistics& statistics, std::size_t row) {
  json all = json::object();
  for (const SweepMetric& metric : sweep_metrics())
    all[metric.key] = to_json(statistics(row, metric.key));
  return all;
}

json runs_json(const SweepTable& t, std::size_t scene, std::size_t row) {
  json runs = json::array();
  for (std::size_t seed = 0; seed < t.seeds.size(); ++seed) {
    const RunOutcome& o = t.at(scene, row, seed);
    runs.push_back({{"seed", t.seeds[seed]},
                    {"state", name_of(o.state)},
                    {"error", o.error.empty() ? json(nullptr) : json(o.error)},
                    {"remarks", o.remarks},
                    {"build", o.build},
                    {"values", o.values},
                    {"curve", o.curve}});
  }
  return runs;
}

json row_json(const SweepRow& row) {
  return {{"group", row.group},
          {"name", row.name},
          {"label", row.label},
          {"preset", row.preset},
          {"options", row.options}};
}

/// A text inside of a table or a list.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : one_line(text, 300)) {
    if (c == '|') safe += '\\';
    safe += c;
  }
  return safe;
}

/// "28.70 ± 0.05", and of how many runs where that is not as many as others in the row are of.
std::string shown(const Statistic& s, const SweepMetric& metric, int runs) {
  if (s.count == 0) return "–";
  std::string text = fmt::format("{:.{}f}", s.mean * metric.shown, metric.digits);
  if (s.count > 1) text += fmt::format(" ± {:.{}f}", s.deviation * metric.shown, metric.digits);
  if (s.count < runs) text += fmt::format(" ({})", s.count);
  return text;
}

/// "3", "2 of 3, 1 failed": runs of a row, on one scene or on all.
std::string runs_of(const SweepTable& t, std::size_t row, std::size_t first, std::size_t last) {
  int finished = 0, failed = 0, all = 0;
  for (std::size_t scene = first; scene < last; ++scene)
    for (std::size_t seed = 0; seed < t.seeds.size(); ++seed, ++all) {
      finished += t.at(scene, row, seed).state == RunState::finished;
      failed += t.at(scene, row, seed).state == RunState::failed;
    }
  if (finished == all) return fmt::format("{}", all);
  std::string text = fmt::format("{} of {}", finished, all);
  if (failed > 0) text += fmt::format(", {} failed", failed);
  return text;
}

/// The rows of one group over scenes [first, last); columns without any number are left out.
std::string group_table(const SweepTable& t, const SweepGroup& group, const Statistics& statistics,
                        std::size_t first, std::size_t last) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < t.rows.size(); ++i)
    if (t.rows[i].group == group.name) rows.push_back(i);
  std::vector<SweepMetric> columns;
  for (const SweepMetric& metric : sweep_metrics())
    if (std::ranges::any_of(rows,
                            [&](std::size_t r) { return statistics(r, metric.key).count > 0; }))
      columns.push_back(metric);
  std::string text = "| |", line = "|---|";
  for (const SweepMetric& metric : columns) {
    text += fmt::format(" {} |", metric.title);
    line += "---:|";
  }
  text += " runs |\n" + line + "---:|\n";
  for (const std::size_t row : rows) {
    text += fmt::format("| {} |", cell(t.rows[row].label));
    int most = 0;
    for (const SweepMetric& metric : columns)
      most = std::max(most, statistics(row, metric.key).count);
    for (const SweepMetric& metric : columns)
      text += fmt::format(" {} |", shown(statistics(row, metric.key), metric, most));
    text += fmt::format(" {} |\n", runs_of(t, row, first, last));
  }
  return text + "\n";
}

std::string group_section(const SweepTable& t, const SweepGroup& group,
                          std::span<const std::string> images) {
  std::string text = fmt::format("## {}\n\n", group.title);
  const bool several = t.scenes.size() > 1;
  if (several) {
    text += fmt::format("Mean over {} scenes:\n\n", t.scenes.size());
    text += group_table(
        t, group, [&](std::size_t row, const char* key) { return over_scenes(t, row, key); }, 0,
        t.scenes.size());
  }
  for (std::size_t scene = 0; scene < t.scenes.size(); ++scene) {
    if (several) text += fmt::format("{}:\n\n", cell(t.scenes[scene].name));
    text += group_table(
        t, group, [&](std::size_t row, const char* key) { return over_seeds(t, scene, row, key); },
        scene, scene + 1);
  }
  std::vector<std::string> shown;
  for (const char* kind : {"", "-curves"}) {
    const std::string image = fmt::format("{}{}.png", group.name, kind);
    if (std::ranges::find(images, image) != images.end())
      shown.push_back(fmt::format("![{}]({})", group.title, image));
  }
  return shown.empty() ? text : text + fmt::format("{}\n\n", fmt::join(shown, " "));
}

/// What some finished runs have and others lack, the number of threads, and who made the runs.
std::vector<std::string> notes_on_runs(const SweepTable& t) {
  int finished = 0, others = 0;
  std::map<std::string, int> having;
  std::set<double> threads;
  std::set<std::string> builds;
  for (const RunOutcome& o : t.outcomes) {
    if (o.state != RunState::finished) continue;
    ++finished;
    builds.insert(o.build);
    others += o.build != t.build;
    for (const auto& [key, value] : o.values) ++having[key];
    if (const auto found = o.values.find("threads"); found != o.values.end())
      threads.insert(found->second);
  }
  std::vector<std::string> notes;
  for (const SweepMetric& metric : sweep_metrics())
    if (const int n = having[metric.key]; n > 0 && n < finished && metric.of_all)
      notes.push_back(fmt::format("{}: of {} of {} finished runs", metric.title, n, finished));
  if (!threads.empty())
    notes.push_back(fmt::format("threads of the trainings: {}", fmt::join(threads, " or ")));
  if (others > 0)
    notes.push_back(
        fmt::format("{} of {} finished runs were made by {} builds of fluxgs {} other "
                    "than the one that wrote this",
                    others, finished, builds.size() - builds.count(t.build), FLUXGS_VERSION));
  return notes;
}

/// Failures and what is missing, the same of several runs in one line.
std::vector<std::string> notes_of(const SweepTable& t) {
  std::map<std::string, int> remarks;
  std::vector<std::string> failures;
  for (std::size_t scene = 0; scene < t.scenes.size(); ++scene)
    for (std::size_t row = 0; row < t.rows.size(); ++row)
      for (std::size_t seed = 0; seed < t.seeds.size(); ++seed) {
        const RunOutcome& o = t.at(scene, row, seed);
        for (const std::string& line : o.remarks) ++remarks[line];
        if (o.state == RunState::failed)
          failures.push_back(fmt::format("{}, {}, seed {} failed: {}", t.scenes[scene].name,
                                         t.rows[row].name, t.seeds[seed], o.error));
      }
  std::vector<std::string> notes = t.notes;
  for (const auto& [line, runs] : remarks)
    notes.push_back(fmt::format("{} ({} of {} runs)", line, runs, t.outcomes.size()));
  notes.insert(notes.end(), failures.begin(), failures.end());
  const std::vector<std::string> more = notes_on_runs(t);
  notes.insert(notes.end(), more.begin(), more.end());
  return notes;
}

}  // namespace

json sweep_json(const SweepTable& t) {
  json scenes = json::array(), results = json::array(), means = json::array();
  for (const SweepScene& s : t.scenes)
    scenes.push_back({{"name", s.name}, {"folder", s.folder}, {"hash", s.hash}});
  for (std::size_t row = 0; row < t.rows.size(); ++row) {
    for (std::size_t scene = 0; scene < t.scenes.size(); ++scene) {
      const auto statistics = [&](std::size_t r, const char* key) {
        return over_seeds(t, scene, r, key);
      };
      json result = row_json(t.rows[row]);
      result["scene"] = t.scenes[scene].name;
      if (row < t.meanings.size()) result["meaning"] = t.meanings[row];
      result["statistics"] = statistics_json(statistics, row);
      result["runs"] = runs_json(t, scene, row);
      results.push_back(std::move(result));
    }
    json mean = row_json(t.rows[row]);
    mean["statistics"] = statistics_json(
        [&](std::size_t r, const char* key) { return over_scenes(t, r, key); }, row);
    means.push_back(std::move(mean));
  }
  return {{"command", t.command},
          {"versions", {{"fluxgs", FLUXGS_VERSION}, {"compiler", __VERSION__}, {"build", t.build}}},
          {"scenes", std::move(scenes)},
          {"seeds", t.seeds},
          {"rows", std::move(results)},
          {"mean_over_scenes", std::move(means)},
          {"notes", notes_of(t)}};
}

std::string sweep_markdown(const SweepTable& t, std::span<const std::string> images) {
  std::string text = fmt::format(
      "# Ablation\n\nMean ± standard deviation over {} seeds, on images that the training did not "
      "see. \"compact\" is the scene as its compact .glb stores it; 1 MB = 10⁶ bytes; time is that "
      "of the training. Minutes and frame times mean something on an idle machine only.\n\n    "
      "{}\n\nfluxgs {}, compiler {}. Data:",
      t.seeds.size(), one_line(t.command, std::string::npos), FLUXGS_VERSION, __VERSION__);
  for (const SweepScene& s : t.scenes)
    text += fmt::format(" {} (files' hash {}){}", cell(s.name), s.hash,
                        &s == &t.scenes.back() ? ".\n\n" : ",");
  for (const SweepGroup& group : sweep_groups())
    if (std::ranges::any_of(t.rows, [&](const SweepRow& r) { return r.group == group.name; }))
      text += group_section(t, group, images);
  const std::vector<std::string> notes = notes_of(t);
  if (!notes.empty()) text += "## Notes\n\n";
  for (const std::string& note : notes) text += fmt::format("- {}\n", cell(note));
  return text;
}

}  // namespace fluxgs::cli
