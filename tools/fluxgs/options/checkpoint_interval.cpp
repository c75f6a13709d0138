#include "tools/fluxgs/options/checkpoint_interval.h"

#include <fmt/format.h>

#include "trainer/model/options.h"

namespace fluxgs::cli {
namespace {

/// Seconds of a unit; 0 where the letter is none.
double unit_seconds(char letter) {
  switch (letter) {
    case 's':
      return 1;
    case 'm':
      return 60;
    case 'h':
      return 3600;
    default:
      return 0;
  }
}

}  // namespace

Expected<CheckpointInterval> parse_checkpoint_interval(const std::string& text) {
  CheckpointInterval interval{.seconds = 0};
  const double unit = text.empty() ? 0 : unit_seconds(text.back());
  double number = 0;
  OptionField time = real("", "", number, 0, 1e6);
  OptionField count = whole("", "", interval.iterations, 0, kUnlimited);
  const bool good = unit > 0 ? set(time, text.substr(0, text.size() - 1)).has_value()
                             : set(count, text).has_value();
  if (!good)
    return fail("", "",
                fmt::format("'{}': expected a time such as 90s, 10m or 1h, a number of iterations "
                            "such as 5000, or 0 for never",
                            text));
  interval.seconds = number * unit;
  return interval;
}

}  // namespace fluxgs::cli
