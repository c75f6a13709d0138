// Trainings of many scenes with many options and seeds, one after the other, that can be stopped
// and gone on with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "tools/fluxgs/sweep_known.h"
#include "tools/fluxgs/sweep_rows.h"
#include "tools/fluxgs/sweep_run.h"
#include "tools/fluxgs/sweep_table.h"

namespace fluxgs::cli {

struct SweepSettings {
  std::vector<std::string> data;  ///< folders of data sets; their last names must differ
  std::filesystem::path out;      ///< runs are in SCENE/ROW/seed-N below
  std::vector<SweepRow> rows;
  std::vector<std::uint64_t> seeds;
  std::vector<std::string> common;  ///< options of `train` for every run; a row's own come first
  SweepMeasures measures = {};
  KnownRuns known = {};  ///< that need not be done again
  bool retry = false;
  std::filesystem::path program;  ///< fluxgs
};

/// Does every run that is neither known nor there yet, all rows with the first seed first. Rows
/// that mean the same to the trainer share their runs, which have the name of the first of them. An
/// interrupt ends it after the training at work has saved its checkpoint; runs that fail are part
/// of the table. Errors: data sets that cannot be read, an output folder that cannot be written or
/// in which another sweep is at work.
Expected<SweepTable> run_sweep(const SweepSettings& settings);

}  // namespace fluxgs::cli
