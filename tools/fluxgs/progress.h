// How far a long piece of work has come, for people.
#pragma once

#include <chrono>
#include <string>

namespace fluxgs::cli {

/// On a terminal one line that is drawn over; otherwise a plain line now and then. Standard error.
class Progress {
 public:
  Progress(int total, int done);

  /// `detail` is shown behind the bar, the rate and the time left. Cheap to call every step.
  void update(int done, const std::string& detail);
  /// Whether update() would show anything now, so that details need not be made for nothing.
  bool due() const;
  /// Says how many steps were done, in what time.
  void finish(int done);

 private:
  using Clock = std::chrono::steady_clock;
  std::string line(int done, const std::string& detail) const;

  int total_, first_;
  bool terminal_;
  Clock::time_point start_, last_;
  int last_done_;
  double rate_ = 0;  // steps per second since the last line
};

}  // namespace fluxgs::cli
