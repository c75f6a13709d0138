// Progress and result of a benchmark or a video that is made on one thread and watched from
// another.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "fluxgs/error.h"

namespace fluxgs::viewer {

struct RunState {
  bool running = false;
  int done = 0, all = 0;  ///< frames
  std::string rows;       ///< of a benchmark that has ended: bench::rows_json()
  std::string stopped;    ///< why, if it ended early
  std::string error;
};

/// How a run ended.
struct RunResult {
  std::string rows;
  std::string stopped;  ///< not empty: early
};

/// All functions may be called from any thread.
class WatchedRun {
 public:
  /// Begins a run. Returns false while another goes on.
  bool begin();
  /// Asks the run to end; the first `why` is what the result says.
  void stop(const std::string& why);
  /// Returns whether the run shall go on.
  bool report(int done, int all);
  void finish(const Expected<RunResult>& result);
  RunState state() const;

 private:
  mutable std::mutex mutex_;
  RunState state_;
  std::optional<std::string> stop_;
};

}  // namespace fluxgs::viewer
