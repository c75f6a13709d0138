// Progress and result of a benchmark that runs on one thread and is watched from another.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "bench/scene_benchmark.h"

namespace fluxgs::viewer {

struct BenchmarkState {
  bool running = false;
  int done = 0, all = 0;  ///< frames
  std::string rows;       ///< bench::rows_json(), when it has ended
  std::string stopped;    ///< why, if it ended early
  std::string error;
};

/// All functions may be called from any thread.
class BenchmarkRun {
 public:
  /// Begins a run. Returns false while another goes on.
  bool begin();
  /// Asks the run to end; the first `why` is what the result says.
  void stop(const std::string& why);
  /// Returns whether the run shall go on.
  bool report(int done, int all);
  void finish(const Expected<bench::SceneBenchmark>& result);
  BenchmarkState state() const;

 private:
  mutable std::mutex mutex_;
  BenchmarkState state_;
  std::optional<std::string> stop_;
};

}  // namespace fluxgs::viewer
