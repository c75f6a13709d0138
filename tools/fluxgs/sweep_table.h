// What a sweep found: means and deviations over seeds, as JSON and as Markdown.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/fluxgs/sweep_rows.h"
#include "tools/fluxgs/sweep_run.h"

namespace fluxgs::cli {

struct Statistic {
  int count = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();  ///< NaN of nothing
  double deviation =
      std::numeric_limits<double>::quiet_NaN();  ///< of a sample, n − 1; NaN for n < 2
};

Statistic statistic_of(std::span<const double> values);

/// Something measured of every run.
struct SweepMetric {
  const char* key;     ///< in JSON and RunOutcome::values
  const char* title;   ///< with the unit that is shown
  double shown;        ///< units shown for one of those stored
  int digits;          ///< after the point
  bool of_all = true;  ///< false: not of every kind of training
};
std::span<const SweepMetric> sweep_metrics();

struct SweepScene {
  std::string name, folder, hash;
};

struct SweepTable {
  std::string command;     ///< that made it
  std::string build = {};  ///< a hash of the program that did
  std::vector<std::string> notes = {};
  std::vector<SweepScene> scenes = {};
  std::vector<SweepRow> rows = {};
  std::vector<nlohmann::json> meanings = {};  ///< training_meaning() of each row
  std::vector<std::uint64_t> seeds = {};
  std::vector<RunOutcome> outcomes = {};  ///< scenes × rows × seeds, seeds fastest
  bool interrupted = false;

  std::size_t index(std::size_t scene, std::size_t row, std::size_t seed) const {
    return (scene * rows.size() + row) * seeds.size() + seed;
  }
  const RunOutcome& at(std::size_t scene, std::size_t row, std::size_t seed) const {
    return outcomes[index(scene, row, seed)];
  }
  int count(RunState state) const;
};

/// Over the finished runs of a row on one scene.
Statistic over_seeds(const SweepTable& table, std::size_t scene, std::size_t row, const char* key);

/// Of the means over all scenes, one for each seed. A seed that lacks a scene does not count, for
/// scenes differ more than rows do.
Statistic over_scenes(const SweepTable& table, std::size_t row, const char* key);

nlohmann::json sweep_json(const SweepTable& table);

/// A table for every group and scene, one for the mean of several scenes, and notes on what is
/// missing or failed. `images` are shown with their groups: files GROUP.png and GROUP-curves.png
/// beside the text.
std::string sweep_markdown(const SweepTable& table, std::span<const std::string> images = {});

}  // namespace fluxgs::cli
