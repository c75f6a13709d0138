#include "viewer/benchmark_run.h"

namespace fluxgs::viewer {

bool BenchmarkRun::begin() {
  const std::lock_guard lock(mutex_);
  if (state_.running) return false;
  state_ = {};
  state_.running = true;
  stop_.reset();
  return true;
}

void BenchmarkRun::stop(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (state_.running && !stop_) stop_ = why;
}

bool BenchmarkRun::report(int done, int all) {
  const std::lock_guard lock(mutex_);
  state_.done = done;
  state_.all = all;
  return !stop_;
}

void BenchmarkRun::finish(const Expected<bench::SceneBenchmark>& result) {
  const std::lock_guard lock(mutex_);
  state_.running = false;
  if (!result) {
    state_.error = result.error().message();
    return;
  }
  state_.rows = bench::rows_json(*result);
  if (!result->stopped.empty()) state_.stopped = stop_.value_or(result->stopped);
}

BenchmarkState BenchmarkRun::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

}  // namespace fluxgs::viewer
