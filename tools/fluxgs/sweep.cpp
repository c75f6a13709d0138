#include "tools/fluxgs/sweep.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/fluxgs/paths.h"
#include "tools/fluxgs/sweep_progress.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The output folder for one sweep alone. Children inherit the lock: should this program be killed,
/// the training that is still at work keeps it.
class FolderLock {
 public:
  static Expected<FolderLock> take(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return fail(folder.string(), "", "cannot be created: " + error.message());
    const fs::path file = folder / ".lock";
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT, 0644);
    if (descriptor < 0) return fail(file.string(), "", "cannot be written");
    FolderLock lock(descriptor);
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0)
      return fail(folder.string(), "", "another sweep is at work in this folder");
    return lock;
  }
  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock() {
    if (descriptor_ >= 0) close(descriptor_);
  }

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

/// The data sets by the last names of their folders.
Expected<std::vector<SweepScene>> scenes_of(const SweepSettings& s) {
  std::vector<SweepScene> scenes;
  for (const std::string& folder : s.data) {
    if (lies_in(s.out, folder))
      return fail(s.out.string(), "--out", "is inside of the data set; expected another folder");
    std::error_code error;
    const std::string name = fs::canonical(folder, error).filename().string();
    if (error) return fail(folder, "", "expected the folder of a data set: " + error.message());
    if (std::ranges::count(scenes, name, &SweepScene::name) > 0)
      return fail(folder, "", "has the same last name as another data set");
    auto hash = hash_of_data(folder);
    if (!hash) return std::unexpected(hash.error());
    scenes.push_back({name, folder, std::move(*hash)});
  }
  return scenes;
}

/// For each row the first of the same meaning, whose runs are its own.
std::vector<SweepRow> representatives_of(const SweepTable& table) {
  std::map<json, SweepRow> first;
  std::vector<SweepRow> rows;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    rows.push_back(first.try_emplace(table.meanings[i], table.rows[i]).first->second);
  return rows;
}

std::vector<std::string> notes_of_sharing(const std::vector<SweepRow>& rows,
                                          const std::vector<SweepRow>& representatives) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].name != representatives[i].name)
      notes.push_back(fmt::format("{} means the same as {} and has its runs", rows[i].name,
                                  representatives[i].name));
  return notes;
}

SweepRun run_of(const SweepSettings& s, const SweepScene& scene, const SweepRow& row, json training,
                std::uint64_t seed) {
  const std::vector<std::string> options = merged_options(s.common, row.options);
  const auto meaning = meaning_of(row.preset, options);
  return {.data = scene.folder,
          .data_hash = scene.hash,
          .folder = s.out / scene.name / row.name / fmt::format("seed-{}", seed),
          .preset = row.preset,
          .options = options,
          .meaning = std::move(training),
          .seed = seed,
          .iterations = meaning ? meaning->iterations : 0};
}

/// What to say of a run.
std::string line_of(const RunOutcome& o) {
  switch (o.state) {
    case RunState::failed:
      return "failed: " + o.error;
    case RunState::interrupted:
      return "interrupted";
    case RunState::finished:
      if (!o.ran) return "";
      return o.values.contains("psnr") ? fmt::format("{:.2f} dB, {:.0f} splats",
                                                     o.values.at("psnr"), o.values.at("splats"))
                                       : "finished";
    case RunState::waiting:
      break;
  }
  return "";
}

}  // namespace

Expected<SweepTable> run_sweep(const SweepSettings& s) {
  auto scenes = scenes_of(s);
  if (!scenes) return std::unexpected(scenes.error());
  const auto lock = FolderLock::take(s.out);
  if (!lock) return std::unexpected(lock.error());
  SweepTable table{.command = "",
                   .build = hash_of_file(s.program).value_or(""),
                   .scenes = std::move(*scenes),
                   .rows = s.rows,
                   .seeds = s.seeds};
  table.outcomes.resize(table.scenes.size() * table.rows.size() * table.seeds.size());

  std::vector<std::pair<std::size_t, SweepRun>> runs;  // places in the table
  for (const SweepRow& row : s.rows) table.meanings.push_back(training_meaning(row, s.common));
  const std::vector<SweepRow> representatives = representatives_of(table);
  table.notes = notes_of_sharing(s.rows, representatives);
  double iterations = 0;
  for (std::size_t seed = 0; seed < s.seeds.size(); ++seed)
    for (std::size_t scene = 0; scene < table.scenes.size(); ++scene)
      for (std::size_t row = 0; row < s.rows.size(); ++row) {
        const std::size_t place = table.index(scene, row, seed);
        if (const RunOutcome* known =
                s.known.find(table.scenes[scene].hash, table.meanings[row], s.seeds[seed])) {
          table.outcomes[place] = *known;
          continue;
        }
        runs.emplace_back(place, run_of(s, table.scenes[scene], representatives[row],
                                        table.meanings[row], s.seeds[seed]));
        iterations += runs.back().second.iterations;
      }

  const InterruptCounter interrupts;
  SweepProgress progress(static_cast<int>(runs.size()), iterations);
  const SweepTools tools{.program = s.program,
                         .interrupts = interrupts,
                         .measures = s.measures,
                         .retry = s.retry,
                         .on_iteration = [&](int iteration) { progress.update(iteration); }};
  std::map<fs::path, RunOutcome> done;
  for (const auto& [place, run] : runs) {
    progress.begin(run.folder.lexically_relative(s.out).string(), run.iterations);
    RunOutcome& outcome = table.outcomes[place];
    const auto known = done.find(run.folder);
    outcome = known != done.end() ? known->second : execute_run(run, tools);
    const bool first = known == done.end();
    progress.end(first && outcome.ran, first ? line_of(outcome) : "");
    done.emplace(run.folder, outcome);
    table.interrupted = interrupts.count() > 0;
    if (table.interrupted) break;
  }
  return table;
}

}  // namespace fluxgs::cli
