// The schedule: all phases of a training in the order in which they run, and the presets.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/core/parallel.h"
#include "trainer/data/dataset.h"
#include "trainer/model/phase.h"

namespace fluxgs {

/// The phases that a training has, and its options with every 0 that stands for "depends on the
/// length of the run" replaced.
struct Schedule {
  TrainOptions options;
  std::vector<std::unique_ptr<Phase>> phases;
};

/// Makes the phases that the options (valid) ask for. `views`: the training views; `views` and
/// `threads` must outlive the schedule.
Schedule make_schedule(TrainOptions options, const std::vector<View>& views,
                       const Threads& threads);

/// The same without views, for looking at the schedule.
Schedule plan_schedule(TrainOptions options);

/// SH degree of the parameters before the first and after the last iteration.
int initial_sh_degree(const TrainOptions& options);
int final_sh_degree(const TrainOptions& options);

/// The options of vanilla 3DGS with all groups of options, in the order of the help.
TrainOptions default_options();

/// Names of the presets, the default one first.
std::vector<std::string> preset_names();

/// The options of a preset: "flux" (our best), "flux-paper" (the paper to the letter), "3dgs"
/// (vanilla: SH of degree 3, single-view gradients), "3dgs-sh1" (the same with SH cut off at the
/// first degree).
Expected<TrainOptions> preset(std::string_view name);

/// The schedule as a table: iterations, phase, what it does. One line for each phase.
std::string plan_table(const Schedule& schedule);

}  // namespace fluxgs
