// Interval of checkpoints, in time or in iterations.
#pragma once

#include <string>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// One of the two is 0, or both: never.
struct CheckpointInterval {
  double seconds = 600;
  int iterations = 0;

  bool never() const { return seconds == 0 && iterations == 0; }
  bool is_due(double seconds_passed, int iteration) const {
    return (seconds > 0 && seconds_passed >= seconds) ||
           (iterations > 0 && iteration % iterations == 0);
  }
};

/// "90s", "10m" or "1.5h"; "5000" or "5k" iterations; "0" is never. The error says so.
Expected<CheckpointInterval> parse_checkpoint_interval(const std::string& text);

}  // namespace fluxgs::cli
