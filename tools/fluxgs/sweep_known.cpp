#include "tools/fluxgs/sweep_known.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/fluxgs/read_json.h"
#include "trainer/train/checkpoint.h"
#include "trainer/train/schedule.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

const std::string kTakenOver = "taken over from another report, with its times";

std::string key_of(const std::string& data_hash, const json& meaning, std::uint64_t seed) {
  return fmt::format("{} {} {}", data_hash, seed, meaning.dump());
}

RunOutcome outcome_of(const json& run) {
  return {.state = RunState::finished,
          .remarks = run.at("remarks"),
          .build = run.at("build"),
          .values = run.at("values"),
          .curve = run.value("curve", json::array())};
}

/// The finished runs, by key_of(). Throws json::exception.
std::map<std::string, RunOutcome> runs_of(const json& report) {
  std::map<std::string, std::string> hashes;
  for (const json& scene : report.at("scenes")) hashes[scene.at("name")] = scene.at("hash");
  std::map<std::string, RunOutcome> runs;
  for (const json& row : report.at("rows")) {
    const auto hash = hashes.find(row.at("scene").get<std::string>());
    if (hash == hashes.end()) continue;
    for (const json& run : row.at("runs"))
      if (run.at("state") == "finished" && !run.at("values").empty())
        runs[key_of(hash->second, row.at("meaning"), run.at("seed"))] = outcome_of(run);
  }
  return runs;
}

}  // namespace

json training_meaning(const SweepRow& row, const std::vector<std::string>& common) {
  const std::vector<std::string> options = merged_options(common, row.options);
  const auto trained = meaning_of(row.preset, options);
  if (!trained) return fmt::format("{} {}", row.preset, fmt::join(options, " "));
  json meaning = {{"data", picked_options(options, {"--downscale", "--background"})}};
  const json usual = options_json(default_options()), all = options_json(*trained);
  for (const auto& [name, value] : all.items())
    if (value != usual.at(name)) meaning[name] = value;
  return meaning;
}

Expected<void> KnownRuns::add(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return add_file(path);
  std::vector<std::filesystem::path> reports;
  for (const auto& entry : std::filesystem::directory_iterator(path, error))
    if (entry.path().extension() == ".json") reports.push_back(entry.path());
  if (reports.empty())
    return fail(path.string(), "", "expected reports of `fluxgs report train` (.json) in it");
  std::ranges::sort(reports);  // so that of a run that two tell of, the same one counts anywhere
  for (const auto& report : reports)
    if (auto added = add_file(report); !added) return added;
  return {};
}

Expected<void> KnownRuns::add_file(const std::filesystem::path& path) {
  auto report = read_json(path);
  if (!report) return std::unexpected(report.error());
  try {
    const std::string version = report->at("versions").at("fluxgs");
    if (version != FLUXGS_VERSION)
      return fail(path.string(), "versions",
                  fmt::format("made by fluxgs {}; expected {}", version, FLUXGS_VERSION));
    for (auto& [key, run] : runs_of(*report)) {
      if (std::ranges::count(run.remarks, kTakenOver) == 0) run.remarks.push_back(kTakenOver);
      runs_.insert_or_assign(key, std::move(run));
    }
    return {};
  } catch (const json::exception& error) {
    return fail(path.string(), "",
                fmt::format("expected a report of `fluxgs report train`: {}", error.what()));
  }
}

const RunOutcome* KnownRuns::find(const std::string& data_hash, const json& meaning,
                                  std::uint64_t seed) const {
  const auto found = runs_.find(key_of(data_hash, meaning, seed));
  return found == runs_.end() ? nullptr : &found->second;
}

}  // namespace fluxgs::cli
