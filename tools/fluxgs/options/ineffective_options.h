// Options of training that have no effect in a run, for warnings.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "trainer/model/options.h"

namespace fluxgs::cli {

/// One line for each reason: which of the options in `given` (names without dashes) have no effect
/// together with the others, and what they need; and what a phase that was asked for will not do as
/// asked.
std::vector<std::string> ineffective_options(const std::set<std::string>& given,
                                             const TrainOptions& options);

}  // namespace fluxgs::cli
