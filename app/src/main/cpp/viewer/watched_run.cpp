#include "viewer/watched_run.h"

namespace fluxgs::viewer {

bool WatchedRun::begin() {
  const std::lock_guard lock(mutex_);
  if (state_.running) return false;
  state_ = {};
  state_.running = true;
  stop_.reset();
  return true;
}

void WatchedRun::stop(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (state_.running && !stop_) stop_ = why;
}

bool WatchedRun::report(int done, int all) {
  const std::lock_guard lock(mutex_);
  state_.done = done;
  state_.all = all;
  return !stop_;
}

void WatchedRun::finish(const Expected<RunResult>& result) {
  const std::lock_guard lock(mutex_);
  state_.running = false;
  if (!result) {
    state_.error = result.error().message();
    return;
  }
  state_.rows = result->rows;
  if (!result->stopped.empty()) state_.stopped = stop_.value_or(result->stopped);
}

RunState WatchedRun::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

}  // namespace fluxgs::viewer
