// Progress bars with the time left.
#pragma once

#include <chrono>
#include <string>

#include "trainer/core/progress.h"

namespace fluxgs::cli {

/// On a terminal one line that is drawn over; otherwise a plain line now and then. Standard error.
class Progress {
 public:
  /// `unit`: what is counted, as the rate shows it.
  Progress(std::string unit, int total, int done);

  /// `detail` is shown behind the bar, the rate and the time left. Cheap to call every iteration.
  void update(int done, const std::string& detail);
  /// True if update() would show anything now, so that details need not be made for nothing.
  bool due() const;
  /// Takes the bar off a terminal.
  void clear() const;
  /// Clears, and says how many iterations were done, in what time.
  void finish(int done) const;

 private:
  using Clock = std::chrono::steady_clock;
  std::string line(int done, const std::string& detail) const;

  std::string unit_;
  int total_, first_;
  bool terminal_;
  Clock::time_point start_, last_;
  int last_done_;
  double rate_ = 0;  // iterations per second since the last line
};

/// "1h03m", "2m05s".
std::string duration(double seconds);

/// For work that the library reports: shows a bar if it takes long, and leaves nothing behind.
ProgressReport show_progress(const std::string& unit);

/// For work of several steps: a bar for each, and one line with its time behind it.
StepReport show_steps();

}  // namespace fluxgs::cli
