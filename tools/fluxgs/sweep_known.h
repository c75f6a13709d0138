// Runs that other sweeps have done, perhaps on other machines, told by their reports.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/error.h"
#include "tools/fluxgs/sweep_rows.h"
#include "tools/fluxgs/sweep_run.h"

namespace fluxgs::cli {

/// What a training of this row means, besides the files of its data set and its seed: an object
/// with the options of the data set, and with those of the method that are not what
/// default_options() have, so that an option which comes to be later changes no older meaning. The
/// text of the options itself where the trainer is going to refuse them.
nlohmann::json training_meaning(const SweepRow& row, const std::vector<std::string>& common);

class KnownRuns {
 public:
  /// Takes the finished runs of a report.json in, or of all .json of a folder. Errors: cannot be
  /// read, not a report of a sweep, or of another version of fluxgs; a folder without any.
  Expected<void> add(const std::filesystem::path& path);

  /// The run of a data set (by its hash) with this meaning and seed, or null.
  const RunOutcome* find(const std::string& data_hash, const nlohmann::json& meaning,
                         std::uint64_t seed) const;

 private:
  Expected<void> add_file(const std::filesystem::path& report);

  std::map<std::string, RunOutcome> runs_;
};

}  // namespace fluxgs::cli
