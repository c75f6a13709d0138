// Progress of long work, counted by the library and shown by the command.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <string>

namespace fluxgs {

/// Called now and then, never by two threads at once; `done` grows up to `total`. May be empty.
using ProgressReport = std::function<void(std::size_t done, std::size_t total)>;

/// The same for work of several steps: `step` says what is done, `unit` what is counted.
using StepReport = std::function<void(const std::string& step, const std::string& unit,
                                      std::size_t done, std::size_t total)>;

/// Counts what several threads finish.
class ProgressCounter {
 public:
  ProgressCounter(const ProgressReport& report, std::size_t total)
      : report_(report), total_(total) {}

  void add_one() {
    if (!report_) return;
    const std::lock_guard lock(mutex_);
    report_(++done_, total_);
  }

 private:
  const ProgressReport& report_;
  std::mutex mutex_;
  std::size_t done_ = 0, total_;
};

}  // namespace fluxgs
