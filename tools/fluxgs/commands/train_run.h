// A training to start, or to go on with from a checkpoint.
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "fluxgs/error.h"
#include "tools/fluxgs/commands/train_log.h"
#include "tools/fluxgs/options/checkpoint_interval.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/method_options.h"
#include "trainer/data/dataset.h"
#include "trainer/train/trainer.h"

namespace fluxgs::cli {

/// The command line of `fluxgs train`.
struct TrainSettings {
  std::string out, float_output, preset = preset_names().front(), backend = "auto", resume, report;
  DataOptions data;
  std::string checkpoint_every_text = "10m";
  CheckpointInterval checkpoint_every = {};
  int preview_every = 0;  ///< iterations; 0: no pictures
  bool plan = false, force = false, preview = false;
  MethodOptions method;
  std::set<std::string> given;  ///< names of all options on the command line, without dashes
};

struct Run {
  TrainOptions options;
  Dataset data;
  TrainState state;
  std::uint64_t views_hash;
  TrainHistory history = {};  ///< of the parts before this one
};

/// The preset with the options of the command line. Errors name the option.
Expected<TrainOptions> options_from(const TrainSettings& settings);

/// Loads the data set and makes its first splats. Errors: options that are refused, images that
/// cannot be read or take too much memory. Leaves in settings.data what the options say of it.
Expected<Run> new_run(TrainSettings& settings, const Threads& threads);

/// The options of the run in settings.resume, with more iterations if these are asked for.
Expected<TrainOptions> resumed_options(const TrainSettings& settings);

/// The run in settings.resume; its options replace those of the settings. Errors: not a checkpoint,
/// or one of other images, fewer iterations than it has. More iterations come after those of its
/// schedule, in which nothing moves.
Expected<Run> resume_run(TrainSettings& settings);

std::string checkpoint_of(const TrainSettings& settings);  ///< OUT.ckpt
/// `history`: of all parts up to now.
Expected<void> save_checkpoint(const std::string& path, const TrainSettings& settings,
                               const Run& run, const TrainHistory& history, const Trainer& trainer);

/// "fluxgs train … --resume OUT.ckpt", with the options that a checkpoint does not hold.
std::string resume_command(const TrainSettings& settings, const std::string& checkpoint);

/// "Checkpoint of iteration 300 saved. Resume with: fluxgs train …", as one would type it.
std::string how_to_resume(const TrainSettings& settings, int iteration);

/// A path as one would type it.
std::string typed(const std::string& path);

}  // namespace fluxgs::cli
