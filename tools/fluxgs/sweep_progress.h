// How far a sweep has come, for people.
#pragma once

#include <chrono>
#include <string>

namespace fluxgs::cli {

/// On a terminal one line that is drawn over, otherwise a line now and then. Standard error. The
/// rate is that of all training so far, measuring included, and so is the time left.
class SweepProgress {
 public:
  /// `iterations`: of all runs together.
  SweepProgress(int runs, double iterations);

  /// The next run is at work on.
  void begin(const std::string& name, int iterations);
  void update(int iteration);
  /// `ran`: it was not there already. `line` is what became of it, empty for nothing to say.
  void end(bool ran, const std::string& line);

 private:
  using Clock = std::chrono::steady_clock;
  double seconds_since(Clock::time_point then) const;

  int runs_, number_ = 0;
  double left_;         // iterations, of the runs after this one
  double trained_ = 0;  // iterations, in runs that ran
  double spent_ = 0;    // seconds, in the same
  std::string name_;
  int iterations_ = 0, first_ = -1;
  bool terminal_;
  Clock::time_point begin_, said_;
};

}  // namespace fluxgs::cli
