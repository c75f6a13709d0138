// Progress bars with the time left.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "trainer/core/progress.h"

namespace fluxgs::cli {

/// On a terminal one line that is drawn over; otherwise a plain line now and then. Standard error.
class Progress {
 public:
  /// `unit`: what is counted, as the rate shows it; without one a percentage is shown.
  Progress(std::string unit, int total, int done);

  /// `detail` is shown behind the bar and the rate. The time left is `seconds_left`, or follows
  /// from the rate of about the last half. Cheap to call every iteration. A bar never goes back.
  void update(int done, const std::string& detail, std::optional<double> seconds_left = {});
  /// True if update() would show anything now, so that details need not be made for nothing.
  bool due() const;
  /// Takes the bar off a terminal. Elsewhere, ends lines that were shown with one of 100%.
  void clear(const std::string& detail = "") const;
  /// Clears, and says how many iterations were done, in what time.
  void finish(int done) const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Mark {
    Clock::time_point time;
    int done;
  };
  std::string line(int done, const std::string& detail, double left) const;
  double seconds_left(const Mark& now);

  std::string unit_;
  int total_;
  bool terminal_;
  Mark start_, last_, middle_, early_;  // the last two: marks behind which rates are measured
  bool shown_ = false;
  double rate_ = 0;  // of the unit a second since the last line
};

/// "1h03m", "2m05s".
std::string duration(double seconds);

/// For work that the library reports: shows a bar if it takes long, and leaves nothing behind.
ProgressReport show_progress(const std::string& unit);

/// The same as a percentage, with a name of the work.
ProgressReport show_work(const std::string& name);

/// For work of several steps: a bar for each, and one line with its time behind it.
StepReport show_steps();

}  // namespace fluxgs::cli
