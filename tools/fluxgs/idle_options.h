// Options of training that a user has given, and that others make ineffective.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "trainer/model/options.h"

namespace fluxgs::cli {

/// One line each: which of the options in `given` (names without dashes) do nothing together with
/// the others in `options`, and what they would need; and what was asked for of the method but will
/// not happen, or not when it was asked for. `compact`: the scene becomes a compact file.
std::vector<std::string> idle_options(const std::set<std::string>& given,
                                      const TrainOptions& options, bool compact);

/// Every name of an option that a line may be about.
std::set<std::string> options_that_may_be_idle();

}  // namespace fluxgs::cli
